#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <tuple>

#include "fit_pictures.h"
#include "focal_frame.h"

namespace aberfit::internal {
namespace {

struct Branch {
  const char* key;  // in file names
  const char* label;
  const FocalLight* light;
  int column;  // column of the curves; gnuplot's line type + 1
};

// Ideal mirror, target if there is one, and fitted surface. Without terms that surface is the ideal mirror
// with the target's scatter and is left out.
std::vector<Branch> branches(const FitPictures& fit) {
  std::vector<Branch> all = {{"ideal", "ideal mirror", &fit.ideal, 2}};
  if (fit.target) all.push_back({"target", "target (Harvey-Shack)", fit.target, 3});
  if (!fit.target || fit.result.fitted.terms.size() > 0)
    all.push_back({"fitted", "fitted surface", &fit.fitted, 4});
  return all;
}

// Sets `curves` of a script, the numbers of the line types, and labels at those numbers.
void set_curves(const std::vector<Branch>& all, const std::string& labels_name,
                const std::vector<std::string>& texts, Picture* picture) {
  std::string curves;
  std::vector<std::string> labels(3);
  for (std::size_t k = 0; k < all.size(); ++k) {
    curves += (k ? " " : "") + std::to_string(all[k].column - 1);
    labels[std::size_t(all[k].column - 2)] = texts[k];
  }
  picture->set("curves", curves);
  picture->set(labels_name, labels);
}

std::vector<std::string> names_of(const std::vector<Branch>& all) {
  std::vector<std::string> names;
  for (const Branch& branch : all) names.emplace_back(branch.label);
  return names;
}

const FocalLight& reference(const FitPictures& fit) { return fit.target ? *fit.target : fit.fitted; }

double spot_scale(const FitPictures& fit) {
  return internal::spot_scale(fit.core_sigma, {&fit.fitted, &fit.ideal});
}

std::string length_text(double value) {
  return std::isfinite(value) ? display(value, Dimension::kLength) : "none";
}

// Limits dz [m] to 0.9 f, because planes for wide scatter may lie behind the mirror, and to the planes where
// the irradiance of the surface is known.
double within_reach(const FitPictures& fit, double dz) {
  const double farthest = std::min(0.9 * fit.mirror.focal_length, fit.fitted.farthest_plane());
  return std::clamp(dz, -farthest, farthest);
}

// Defocus f sigma_f / R at which the geometric blur of the rim equals the spot.
double plane_unit(const FitPictures& fit) {
  return fit.mirror.focal_length * spot_scale(fit) / aperture_radius(fit.aperture);
}

// Step of about `wanted` between tics: 1, 2 or 5 times a power of ten.
double nice_step(double wanted) {
  if (!(wanted > 0)) return 1;
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (wanted <= factor * decade) return factor * decade;
  return 10 * decade;
}

// Radii and fractions of the EE targets at the focus.
std::pair<Eigen::ArrayXd, Eigen::ArrayXd> fitted_fractions(const ResultDocument& result) {
  std::vector<double> radius, fraction;
  for (const Target& target : result.fitted.targets)
    if (const auto* ee = std::get_if<EncircledEnergyRadius>(&target.statistic); ee && ee->dz == 0) {
      radius.push_back(target.value);
      fraction.push_back(ee->fraction);
    }
  return {array_of(radius), array_of(fraction)};
}

// Sets labels with ee50 and ee90 of each curve, and the radii of the script's vertical lines. The ideal
// mirror has no lines, nor has a perfect focus, whose radii are rounding errors.
void set_ee_radii(const std::vector<Branch>& all, double last, Picture* picture) {
  std::vector<std::string> labels;
  std::vector<double> ee50(3, NAN), ee90(3, NAN);
  for (const Branch& branch : all) {
    const double half = branch.light->statistic(EncircledEnergyRadius{0.5, 0.0}),
                 most = branch.light->statistic(EncircledEnergyRadius{0.9, 0.0});
    const bool is_point = most < 1e-6 * last;
    labels.push_back(
        fmt::format("{}: {}", branch.label,
                    is_point ? "a point" : "ee50 " + length_text(half) + ", ee90 " + length_text(most)));
    if (is_point || std::isnan(most)) continue;
    ee50[std::size_t(branch.column - 2)] = half;
    ee90[std::size_t(branch.column - 2)] = most;
  }
  set_curves(all, "label", labels, picture);
  picture->set("ee50", ee50);
  picture->set("ee90", ee90);
}

}  // namespace

Picture ee_curves_picture(const FitPictures& fit) {
  constexpr int kPoints = 501;
  const auto [asked_radius, asked_fraction] = fitted_fractions(fit.result);
  const double reach = std::max(curve_end(reference(fit)), curve_end(fit.fitted));
  const double asked = asked_radius.size() > 0 ? asked_radius.maxCoeff() : 0.0;
  const double last = reach > 0 ? std::max(1.2 * reach, 1.05 * asked) : 4 * spot_scale(fit);
  const Eigen::ArrayXd radii = Eigen::ArrayXd::LinSpaced(kPoints, 0.0, last);
  const Eigen::ArrayXd fitted = fit.fitted.encircled_energy(radii);
  Eigen::ArrayXd target = Eigen::ArrayXd::Constant(kPoints, NAN), error = target;
  if (fit.target) {
    target = fit.target->encircled_energy(radii);
    error = (target * (1.0 - target) / fit.target->sample_size()).sqrt();  // binomial
  }
  Picture picture("ee_curves", fit.result.title);
  picture.add_columns("ee_curves.dat",
                      {"Encircled energy: fraction of the energy within a radius of the centre at z = f",
                       "columns: radius_m ideal target fitted standard_error_of_target (nan: no target)"},
                      {radii, fit.ideal.encircled_energy(radii), target, fitted, error});
  if (asked_radius.size() > 0)
    picture.add_columns(
        "ee_targets.dat",
        {"Encircled-energy radii that are targets of the fit at z = f", "columns: radius_m fraction"},
        {asked_radius, asked_fraction});
  picture.set("last", last);
  picture.set("r", length_unit(last));
  picture.set("asked", int(asked_radius.size() > 0));
  picture.set("has_target", int(fit.target != nullptr));
  picture.set("counted", int(fit.target && std::isfinite(fit.target->sample_size())));
  picture.set("difference_step",
              nice_step(50 * std::max(largest_size(fitted - target), largest_size(error))));
  set_ee_radii(branches(fit), last, &picture);
  return picture;
}

namespace {

// The FWHM through a ring, if its curve shows both halves. A search for planes outside of the picture would
// take minutes.
std::string width_text(const FocalLight& light, double ring, const Eigen::ArrayXd& curve) {
  double peak = 0, first = NAN, last = NAN;
  for (const double share : curve) {
    if (!std::isfinite(share)) continue;
    if (std::isnan(first)) first = share;
    last = share;
    peak = std::max(peak, share);
  }
  if (first < 0.5 * peak && last < 0.5 * peak) return length_text(light.statistic(RingFwhm{0.9, ring}));
  return std::isfinite(last) ? "beyond these planes" : "none";
}

using Curve = std::map<double, double>;  // fraction of the energy inside a ring, by plane [m]

// Value at `plane` of the polynomial through the two points on either side, without the point there.
double by_neighbours(const Curve& curve, double plane) {
  std::vector<Curve::const_iterator> about;
  for (auto at = curve.upper_bound(plane); at != curve.end() && about.size() < 2; ++at) about.push_back(at);
  const std::size_t above = about.size();
  for (auto at = curve.lower_bound(plane); at != curve.begin() && about.size() < above + 2;)
    about.push_back(--at);
  double sum = 0;
  for (const auto& i : about) {
    double weight = 1;
    for (const auto& j : about)
      if (j != i) weight *= (plane - j->first) / (i->first - j->first);
    sum += weight * i->second;
  }
  return sum;
}

// A plane of wave optics may take a tenth of a second, so we compute as few as a smooth curve needs. If the
// interpolation from its neighbours misses a plane, we add planes halfway to both neighbours. Halfway between
// planes, the error of a cubic is a seventh of that miss, here less than two pixels.
Eigen::ArrayXd smooth_curve(const FocalLight& light, double ring, const Eigen::ArrayXd& drawn) {
  constexpr int kFirst = 21, kRounds = 2;
  constexpr double kMiss = 0.01;
  Curve known;
  Eigen::ArrayXd planes = Eigen::ArrayXd::LinSpaced(kFirst, drawn[0], drawn[drawn.size() - 1]);
  for (int round = 0; planes.size() > 0; ++round) {
    const Eigen::ArrayXd share = light.ring_through(ring, planes);
    for (Eigen::Index k = 0; k < planes.size(); ++k) known[planes[k]] = share[k];
    std::set<double> between;
    for (auto at = std::next(known.begin()); round < kRounds && std::next(at) != known.end(); ++at)
      if (std::abs(by_neighbours(known, at->first) - at->second) > kMiss)
        for (const auto beside : {std::prev(at), std::next(at)})
          between.insert(0.5 * (at->first + beside->first));
    planes = array_of({between.begin(), between.end()});
  }
  return drawn.unaryExpr([&](double plane) {
    const auto at = known.find(plane);
    return at == known.end() ? by_neighbours(known, plane) : at->second;
  });
}

}  // namespace

Picture ring_through_picture(const FitPictures& fit) {
  constexpr double kReach = 4;  // in units of ring f / R; half maximum is near 1.4
  double ring = reference(fit).statistic(EncircledEnergyRadius{0.9, 0.0});
  if (!(ring > 1e-12)) ring = 2 * spot_scale(fit);
  const double last =
      within_reach(fit, kReach * ring * fit.mirror.focal_length / aperture_radius(fit.aperture));
  const bool smooth = fit.result.scene.model == "waves";  // rays give all planes at once
  const Eigen::ArrayXd planes = Eigen::ArrayXd::LinSpaced(smooth ? 201 : 1001, -last, last);
  const Eigen::ArrayXd none = Eigen::ArrayXd::Constant(planes.size(), NAN);
  PictureColumns columns = {planes, none, none, none};
  std::vector<std::string> labels;
  const std::vector<Branch> all = branches(fit);
  for (const Branch& branch : all) {
    Eigen::ArrayXd& curve = columns[std::size_t(branch.column - 1)];
    curve = smooth ? smooth_curve(*branch.light, ring, planes) : branch.light->ring_through(ring, planes);
    labels.push_back(fmt::format("{}: FWHM {}", branch.label, width_text(*branch.light, ring, curve)));
  }
  Picture picture("ring_through", fit.result.title);
  picture.add_columns(
      "ring_through.dat",
      {fmt::format("Fraction of the energy inside a ring of radius {:.9g} m, centred on the focus", ring),
       "columns: plane_dz_m (offset from z = f) ideal target fitted (nan: no target)"},
      columns);
  set_curves(all, "label", labels, &picture);
  picture.set("last", last);
  picture.set("z", length_unit(last));
  picture.set("ring", length_text(ring));
  picture.set("half_maximum", 0.5 * columns[fit.target ? 2 : 3].maxCoeff());
  picture.set("reference", fit.target ? "target" : "fitted surface");
  return picture;
}

namespace {

struct Plane {
  const char* key;
  double units;  // dz in units of plane_unit
};
constexpr Plane kPlanes[] = {{"before", -2.0}, {"focus", 0.0}, {"behind", 2.0}};
constexpr int kPixels = 129;  // odd, so that the centre is a pixel

// Adds an image of the irradiance over +-half [m].
void add_image(const Branch& branch, const std::string& file, double dz, double half,
               const Eigen::ArrayXXd& image, Picture* picture) {
  const double pixel = 2 * half / kPixels;
  picture->add_matrix(
      file,
      {fmt::format("Fraction of the energy per pixel, {} at dz = {:.9g} m from z = f", branch.label, dz),
       fmt::format(
           "{0} x {0} pixels of {1:.9g} m; rows from -y to +y, columns from -x to +x; the first pixel is "
           "centred on {2:.9g} m in x and y",
           kPixels, pixel, -half + 0.5 * pixel)},
      image);
}

void set_image_frame(double half, const std::vector<Branch>& rows, Picture* picture) {
  const double pixel = 2 * half / kPixels;
  std::vector<std::string> keys;
  for (const Branch& row : rows) keys.emplace_back(row.key);
  picture->set("half", half);
  picture->set_pixels(-half + 0.5 * pixel, pixel, -half + 0.5 * pixel, pixel);
  picture->set("x", length_unit(half));
  picture->set("rows", int(rows.size()));
  picture->set("key", keys);
  picture->set("surface", names_of(rows));
}

std::string plane_text(double dz) {
  if (dz == 0) return "z = f";
  return length_text(std::abs(dz)) + (dz < 0 ? " before z = f" : " behind z = f");
}

}  // namespace

Picture focal_images_picture(const FitPictures& fit) {
  constexpr double kDecades = 2.5, kHalfWidth = 5;    // at that many sigmas
  constexpr int kRowHeight = 415, kHeadHeight = 130;  // [pixels]
  const double ring = reference(fit).statistic(EncircledEnergyRadius{0.9, 0.0});
  const double scale = spot_scale(fit), half = image_half_width(ring, scale);
  const double decades = kDecades + 2 * std::log10(half / (kHalfWidth * scale));
  const std::vector<Branch> rows = branches(fit);
  Picture picture("focal_images", fit.result.title);
  double brightest = 0;
  std::vector<std::string> planes;
  for (const Plane& plane : kPlanes) {
    const double dz = within_reach(fit, plane.units * plane_unit(fit));
    planes.push_back(plane_text(dz));
    for (const Branch& row : rows) {
      const Eigen::ArrayXXd image = row.light->image(dz, half, kPixels);
      if (row.column > 2) brightest = std::max(brightest, image.maxCoeff());
      add_image(row, fmt::format("focal_images_{}_{}.dat", row.key, plane.key), dz, half, image, &picture);
    }
  }
  set_image_frame(half, rows, &picture);
  picture.set("height", kHeadHeight + kRowHeight * int(rows.size()));
  picture.set("plane", planes);
  picture.set("ring", ring);
  picture.set("brightest", brightest > 0 ? brightest : 1.0);
  picture.set("faintest", std::pow(10.0, -decades) * (brightest > 0 ? brightest : 1.0));
  return picture;
}

std::optional<Picture> focal_core_picture(const FitPictures& fit) {
  constexpr double kAiryRadii = 4;
  if (fit.result.scene.model != "waves") return std::nullopt;
  const double airy = 0.61 * fit.wavelength * fit.mirror.focal_length / aperture_radius(fit.aperture);
  const double half = kAiryRadii * airy;
  // Then focal_images shows the core already.
  if (image_half_width(reference(fit).statistic(EncircledEnergyRadius{0.9, 0.0}), spot_scale(fit)) <
      1.5 * half)
    return std::nullopt;
  const std::vector<Branch> rows = branches(fit);
  Picture picture("focal_core", fit.result.title);
  std::vector<double> peaks;
  for (const Branch& row : rows) {
    const Eigen::ArrayXXd image = row.light->image(0, half, kPixels);
    peaks.push_back(image.maxCoeff());
    add_image(row, fmt::format("focal_core_{}.dat", row.key), 0, half, image, &picture);
  }
  set_image_frame(half, rows, &picture);
  picture.set("airy", airy);
  const double ideal_peak = peaks[0] > 0 ? peaks[0] : 1;
  picture.set("brightest", ideal_peak);
  for (double& peak : peaks) peak /= ideal_peak;
  picture.set("faintest", 0.1 * std::min(0.01, *std::min_element(peaks.begin(), peaks.end())));
  picture.set("peak", peaks);
  return picture;
}

namespace {

// Modulus of a transfer function by lag: mean, smallest and largest over directions.
PictureColumns round_modulus(const TransferImage& otf) {
  const Eigen::Index count = otf.middle + 1;
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(count), weight = sum, most = sum,
                 least = Eigen::ArrayXd::Constant(count, HUGE_VAL);
  for (Eigen::Index row = 0; row < otf.value.rows(); ++row)
    for (Eigen::Index column = 0; column < otf.value.cols(); ++column) {
      const double lag = std::hypot(double(row - otf.middle), double(column - otf.middle));
      const auto k = Eigen::Index(std::lround(lag));
      if (k >= count) continue;
      const double modulus = std::abs(otf.value(row, column));
      sum[k] += modulus, weight[k] += 1;
      least[k] = std::min(least[k], modulus), most[k] = std::max(most[k], modulus);
    }
  return {otf.step * Eigen::ArrayXd::LinSpaced(count, 0.0, double(otf.middle)), sum / weight, least, most};
}

// A curve at other frequencies, which begin at 0; 0 beyond its own range.
Eigen::ArrayXd interpolated(const Eigen::ArrayXd& frequency, const Eigen::ArrayXd& value,
                            const Eigen::ArrayXd& wanted) {
  return wanted.unaryExpr([&](double f) {
    const double at = f / frequency[1];
    const auto k = Eigen::Index(at);
    if (k + 1 >= value.size()) return 0.0;
    return value[k] + (at - double(k)) * (value[k + 1] - value[k]);
  });
}

}  // namespace

std::optional<Picture> mtf_picture(const FitPictures& fit) {
  constexpr Eigen::Index kPoints = 301;
  const std::optional<TransferImage> ideal = fit.ideal.transfer(), fitted = fit.fitted.transfer();
  if (!ideal || !fitted || ideal->middle < 2 || fitted->middle < 2) return std::nullopt;
  const double cutoff = 2 * aperture_radius(fit.aperture) / (fit.wavelength * fit.mirror.focal_length);
  const double last = std::min(cutoff, fitted->step * double(fitted->middle));
  const Eigen::ArrayXd frequency = Eigen::ArrayXd::LinSpaced(kPoints, 0.0, last);
  const PictureColumns of_ideal = round_modulus(*ideal), of_fitted = round_modulus(*fitted);
  const auto at = [&](const PictureColumns& curve, std::size_t k) {
    return interpolated(curve[0], curve[k], frequency);
  };
  Eigen::ArrayXd target = Eigen::ArrayXd::Constant(kPoints, NAN);
  std::vector<Branch> all = branches(fit);
  if (fit.target)
    if (const auto known = fit.target->round_transfer(frequency)) target = known->abs();
  if (!target.isFinite().any()) std::erase_if(all, [](const Branch& branch) { return branch.column == 3; });
  Picture picture("mtf", fit.result.title);
  picture.add_columns(
      "mtf.dat",
      {"Modulus of the transfer function at z = f, means over directions; then its least and its "
       "largest value over directions, of the fitted surface",
       "columns: frequency_per_m ideal target fitted fitted_least fitted_largest"},
      {frequency, at(of_ideal, 1), target, at(of_fitted, 1), at(of_fitted, 2), at(of_fitted, 3)});
  picture.set("last", last);
  picture.set("has_fitted", int(all.back().column == 4));
  set_curves(all, "surface", names_of(all), &picture);
  return picture;
}

}  // namespace aberfit::internal
