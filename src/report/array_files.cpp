// This file writes the arrays of the focus in formats of other programs.
#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "aberfit/core/constants.h"
#include "aberfit/measured/write_fits.h"
#include "aberfit/report/arrays.h"
#include "coefficient_listing.h"
#include "npz.h"

namespace aberfit {
using namespace internal;

namespace {

using Files = std::vector<std::pair<std::string, std::string>>;

// Calls `use` for theory and surface if present, each with its word for file names.
void for_each_light(const FocusArrays& arrays,
                    const std::function<void(const std::string&, const LightArrays&)>& use) {
  if (arrays.theory) use("theory", *arrays.theory);
  if (arrays.surface) use("surface", *arrays.surface);
}

const TransferImage* surface_otf(const FocusArrays& arrays) {
  return arrays.surface && arrays.surface->otf ? &*arrays.surface->otf : nullptr;
}

Eigen::ArrayXd ring_radius(const FocusArrays& arrays) {
  const Eigen::Index rings = arrays.radius.size() - 1;
  return 0.5 * (arrays.radius.head(rings) + arrays.radius.tail(rings));
}

// Positive and negative frequencies along x and y of the surface's OTF.
Eigen::ArrayXd both_ways(const TransferImage& otf) {
  const auto last = double(otf.middle);
  return otf.step * Eigen::ArrayXd::LinSpaced(2 * otf.middle + 1, -last, last);
}

// Moduli from frequency 0 on, with the names of their axes.
std::vector<std::pair<std::string, Eigen::ArrayXd>> moduli(const TransferImage& otf) {
  const Eigen::Index m = otf.middle;
  return {{"surface_x", otf.value.row(m).tail(m + 1).abs().transpose()},
          {"surface_y", otf.value.col(m).tail(m + 1).abs()}};
}

NpyArray line(const std::string& name, const Eigen::ArrayXd& values) {
  return {name, {values.size()}, {values.begin(), values.end()}};
}

NpyArray matrix(const std::string& name, const Eigen::ArrayXXd& values) {
  NpyArray array{name, {values.rows(), values.cols()}, std::vector<double>(std::size_t(values.size()))};
  Eigen::Map<Grid>(array.values.data(), values.rows(), values.cols()) = values;
  return array;
}

Files npz_files(const FocusArrays& arrays) {
  std::vector<NpyArray> all = {{"wavelength_m", {}, {arrays.wavelength}},
                               {"focal_length_m", {}, {arrays.focal_length}},
                               {"diameter_m", {}, {arrays.diameter}},
                               line("plane_dz_m", arrays.plane),
                               line("ee_radius_m", arrays.radius),
                               line("ring_radius_m", ring_radius(arrays)),
                               line("psf_x_m", arrays.pixel),
                               line("psf_y_m", arrays.pixel)};
  for_each_light(arrays, [&](const std::string& whose, const LightArrays& light) {
    all.push_back(matrix("ee_" + whose, light.encircled_energy));
    all.push_back(matrix("ring_" + whose + "_per_m2", light.ring_profile));
    all.push_back(matrix("psf_" + whose + "_per_m2", light.psf));
  });
  if (arrays.frequency.size() > 0) all.push_back(line("mtf_frequency_per_m", arrays.frequency));
  if (arrays.theory && arrays.theory->mtf) all.push_back(line("mtf_theory", *arrays.theory->mtf));
  if (const TransferImage* otf = surface_otf(arrays)) {
    for (const auto& [name, values] : moduli(*otf)) all.push_back(line("mtf_" + name, values));
    all.push_back(line("otf_fx_per_m", both_ways(*otf)));
    all.push_back(line("otf_fy_per_m", both_ways(*otf)));
    all.push_back(matrix("otf_surface_real", otf->value.real()));
    all.push_back(matrix("otf_surface_imag", otf->value.imag()));
  }
  if (arrays.halo) {
    all.push_back(matrix("halo", arrays.halo->fraction));
    all.push_back({"halo_core", {}, {arrays.halo->core}});
    all.push_back({"halo_beyond", {}, {arrays.halo->beyond}});
  }
  Files members;
  for (const NpyArray& array : all) members.emplace_back(array.name + ".npy", npy_bytes(array));
  return {{"arrays.npz", stored_zip(members)}};
}

using Columns = std::vector<std::pair<std::string, Eigen::ArrayXd>>;

std::string columns_csv(const std::string& comment, const Columns& columns) {
  std::string text = "# " + comment + "\n";
  for (std::size_t k = 0; k < columns.size(); ++k) text += (k > 0 ? "," : "") + columns[k].first;
  text += '\n';
  for (Eigen::Index row = 0; row < columns.front().second.size(); ++row)
    for (std::size_t k = 0; k < columns.size(); ++k)
      text += fmt::format("{}{}", columns[k].second[row], k + 1 < columns.size() ? ',' : '\n');
  return text;
}

// A square image with `axis` in both directions.
std::string image_csv(const std::string& comment, const std::string& axes, const Eigen::ArrayXd& axis,
                      const Eigen::ArrayXXd& values) {
  std::string text = fmt::format(
      "# {}\n# rows: {} of the second axis from {} to {} in equal steps; columns: the same of the first\n",
      comment, axes, axis[0], axis[axis.size() - 1]);
  for (Eigen::Index row = 0; row < values.rows(); ++row)
    for (Eigen::Index column = 0; column < values.cols(); ++column)
      text += fmt::format("{}{}", values(row, column), column + 1 < values.cols() ? ',' : '\n');
  return text;
}

// Columns of plane and `along`, and of `values` for theory and surface.
Columns by_plane(const FocusArrays& arrays, const Eigen::ArrayXd& along, const std::string& suffix,
                 Eigen::ArrayXXd LightArrays::*values) {
  const Eigen::Index planes = arrays.plane.size(), each = along.size();
  Columns columns = {{"plane_dz_m", Eigen::ArrayXd(planes * each)}, {"radius_m", along.replicate(planes, 1)}};
  for (Eigen::Index k = 0; k < planes; ++k) columns[0].second.segment(k * each, each) = arrays.plane[k];
  for_each_light(arrays, [&](const std::string& whose, const LightArrays& light) {
    const Eigen::ArrayXXd in_turn = (light.*values).transpose();
    columns.emplace_back(whose + suffix, in_turn.reshaped());
  });
  return columns;
}

Files csv_files(const FocusArrays& arrays) {
  Files files = {
      {"arrays/encircled_energy.csv",
       columns_csv("fraction of the energy within the radius, in planes dz from z = f",
                   by_plane(arrays, arrays.radius, "", &LightArrays::encircled_energy))},
      {"arrays/ring_profile.csv",
       columns_csv("mean irradiance of rings, as fraction of the energy per m^2, at the middle of each",
                   by_plane(arrays, ring_radius(arrays), "_per_m2", &LightArrays::ring_profile))}};
  for_each_light(arrays, [&](const std::string& whose, const LightArrays& light) {
    files.emplace_back(
        "arrays/psf_" + whose + ".csv",
        image_csv("mean irradiance of pixels at z = f, as fraction of the energy per m^2, of the " + whose,
                  "centres [m]", arrays.pixel, light.psf));
  });
  if (arrays.halo)
    files.emplace_back(
        "arrays/halo.csv",
        image_csv(fmt::format("fraction of the energy that the roughness beside the terms scatters, per "
                              "pixel; core {}, beyond the frame {}",
                              arrays.halo->core, arrays.halo->beyond),
                  "centres [m]", arrays.pixel, arrays.halo->fraction));
  Columns mtf = {{"frequency_per_m", arrays.frequency}};
  if (arrays.theory && arrays.theory->mtf) mtf.emplace_back("theory", *arrays.theory->mtf);
  if (const TransferImage* otf = surface_otf(arrays)) {
    for (auto& one : moduli(*otf)) mtf.push_back(std::move(one));
    const auto part = [&](const std::string& name, const Eigen::ArrayXXd& values) {
      files.emplace_back("arrays/otf_surface_" + name + ".csv",
                         image_csv("OTF of the surface at z = f, part: " + name, "frequencies [1/m]",
                                   both_ways(*otf), values));
    };
    part("real", otf->value.real());
    part("imag", otf->value.imag());
  }
  if (mtf.size() > 1)
    files.emplace_back(
        "arrays/mtf.csv",
        columns_csv("transfer function at z = f: real part of theory's, modulus of the surface's", mtf));
  return files;
}

constexpr double kArcsecPerRadian = 180 * 3600 / kPi;

// Header cards for the scene in every file. Names are those of POPPY (its page "FITS header keywords") where
// it has one.
std::vector<FitsCard> scene_cards(const FocusArrays& arrays, const std::string& light) {
  return {{"ORIGIN", std::string("aberfit"), ""},
          {"OBJECT", one_line(arrays.title, 68), ""},
          {"LIGHT", light, "of the surface, or of theory (mean of mirrors)"},
          {"WAVELEN", arrays.wavelength, "[m] wavelength"},
          {"DIAM", arrays.diameter, "[m] diameter of the aperture"},
          {"FLEN", arrays.focal_length, "[m] focal length"},
          {"DIFFLMT", arrays.wavelength / arrays.diameter * kArcsecPerRadian, "[arcsec] lambda/D"},
          {"PLANE_DZ", 0.0, "[m] plane, distance from z = f"}};
}

// A linear axis whose middle is 0.
void add_axis(int number, const char* type, const char* unit, Eigen::Index count, double step,
              std::vector<FitsCard>* cards) {
  const auto key = [&](const char* name) { return fmt::format("{}{}", name, number); };
  cards->push_back({key("CTYPE"), std::string(type), "linear"});
  cards->push_back({key("CUNIT"), std::string(unit), ""});
  cards->push_back({key("CRPIX"), 0.5 * double(count + 1), ""});
  cards->push_back({key("CRVAL"), 0.0, ""});
  cards->push_back({key("CDELT"), step, ""});
}

FitsImageUnit psf_unit(const FocusArrays& arrays, const std::string& whose, const LightArrays& light) {
  const double pixel = arrays.pixel[1] - arrays.pixel[0];
  const double arcsec = pixel / arrays.focal_length * kArcsecPerRadian;
  const Eigen::Index count = arrays.pixel.size();
  FitsImageUnit image{"", light.psf, scene_cards(arrays, whose)};
  image.cards.push_back({"BUNIT", std::string("m-2"), "fraction of energy per area"});
  image.cards.push_back({"PIXAREA", pixel * pixel, "[m2] sum(image) PIXAREA: energy inside"});
  image.cards.push_back({"PIXELSCL", arcsec, "[arcsec] per pixel, on the sky"});
  image.cards.push_back({"PIXUNIT", std::string("arcsecond"), "of PIXELSCL"});
  image.cards.push_back({"FOV", arcsec * double(count), "[arcsec] of the whole image"});
  add_axis(1, "X", "m", count, pixel, &image.cards);
  add_axis(2, "Y", "m", count, pixel, &image.cards);
  return image;
}

FitsImageUnit halo_unit(const FocusArrays& arrays) {
  const double pixel = arrays.pixel[1] - arrays.pixel[0];
  FitsImageUnit image{"HALO", arrays.halo->fraction, scene_cards(arrays, "scatter")};
  image.cards.push_back({"CORE", arrays.halo->core, "fraction not scattered"});
  image.cards.push_back({"BEYOND", arrays.halo->beyond, "fraction scattered beyond the frame"});
  image.cards.push_back({"PIXELSCL", pixel / arrays.focal_length * kArcsecPerRadian, "[arcsec] per pixel"});
  add_axis(1, "X", "m", arrays.pixel.size(), pixel, &image.cards);
  add_axis(2, "Y", "m", arrays.pixel.size(), pixel, &image.cards);
  return image;
}

FitsImageUnit otf_unit(const FocusArrays& arrays, const std::string& name, const Eigen::ArrayXXd& values) {
  const TransferImage& otf = *surface_otf(arrays);
  FitsImageUnit image{name, values, scene_cards(arrays, "surface")};
  add_axis(1, "FX", "m-1", values.cols(), otf.step, &image.cards);
  add_axis(2, "FY", "m-1", values.rows(), otf.step, &image.cards);
  return image;
}

FitsImageUnit theory_mtf_unit(const FocusArrays& arrays) {
  const Eigen::ArrayXd& values = *arrays.theory->mtf;
  FitsImageUnit image{"THEORY", values.transpose(), scene_cards(arrays, "theory")};
  add_axis(1, "F", "m-1", 1, arrays.frequency[1], &image.cards);  // from 0 on
  return image;
}

Files fits_files(const FocusArrays& arrays) {
  std::vector<FitsImageUnit> psf, otf;
  if (arrays.surface) psf.push_back(psf_unit(arrays, "surface", *arrays.surface));
  if (arrays.theory) psf.push_back(psf_unit(arrays, "theory", *arrays.theory));
  psf.back().name = arrays.theory ? "THEORY" : "";
  if (arrays.halo) psf.push_back(halo_unit(arrays));
  if (const TransferImage* surface = surface_otf(arrays)) {
    otf.push_back(otf_unit(arrays, "", surface->value.abs()));
    otf.push_back(otf_unit(arrays, "REAL", surface->value.real()));
    otf.push_back(otf_unit(arrays, "IMAG", surface->value.imag()));
  }
  if (arrays.theory && arrays.theory->mtf) otf.push_back(theory_mtf_unit(arrays));
  Files files = {{"psf.fits", fits_bytes(psf)}};
  if (!otf.empty()) files.emplace_back("otf.fits", fits_bytes(otf));
  return files;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> array_files(ArrayFormat format, const FocusArrays& arrays) {
  switch (format) {
    case ArrayFormat::kNone:
      return {};
    case ArrayFormat::kNpz:
      return npz_files(arrays);
    case ArrayFormat::kCsv:
      return csv_files(arrays);
    case ArrayFormat::kFits:
      return fits_files(arrays);
  }
  return {};
}

}  // namespace aberfit
