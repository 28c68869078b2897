// The arrays behind the pictures. Their values are compared with closed forms and a second method, and the
// files with readers that know only the formats.
#include "aberfit/report/arrays.h"

#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

#include "../../src/report/npz.h"
#include "aberfit/core/random.h"
#include "aberfit/measured/clear_aperture.h"
#include "aberfit/measured/focal_data.h"
#include "fits_reader.h"
#include "npz_reader.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using internal::NpyArray;
using test::NpzReader;
using test::read_fits_units;

// At f/70 the direction cosines of the rim change the Airy pattern by 1e-5 of the energy.
constexpr double kFocalLength = 28, kRadius = 0.2, kWavelength = 632.8e-9;
constexpr double kUnit = kWavelength * kFocalLength / (2 * kRadius);  // lambda F [m]
constexpr double kCutoff = 1 / kUnit;                                 // [cycles/m]

// Born and Wolf, 8.5.2.
double airy_share(double radius) {
  const double z = std::numbers::pi * radius / kUnit;
  return 1 - std::pow(boost::math::cyl_bessel_j(0, z), 2) - std::pow(boost::math::cyl_bessel_j(1, z), 2);
}

double airy_irradiance(double radius) {
  const double z = std::numbers::pi * radius / kUnit;
  return std::numbers::pi / 4 / (kUnit * kUnit) * std::pow(2 * boost::math::cyl_bessel_j(1, z) / z, 2);
}

// Goodman, Introduction to Fourier Optics, 6.31.
double circle_mtf(double frequency) {
  const double s = frequency / kCutoff;
  return s < 1 ? 2 / std::numbers::pi * (std::acos(s) - s * std::sqrt(1 - s * s)) : 0;
}

// Energy of a round spot inside a square, from the fraction of each circle inside the square.
double share_in_square(double half, const std::function<double(double)>& encircled) {
  constexpr int kSteps = 20000;
  const double last = std::numbers::sqrt2 * half;
  double sum = 0, before = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double middle = (k + 0.5) * last / kSteps, energy = encircled((k + 1) * last / kSteps);
    const double inside = middle <= half ? 1 : 1 - 4 / std::numbers::pi * std::acos(half / middle);
    sum += (energy - before) * inside;
    before = energy;
  }
  return sum;
}

struct Scene {
  Mirror mirror{kFocalLength, -1, {}};
  Aperture aperture = CircleAperture{2 * kRadius, 0};
  PupilSample pupil;
  TermSet terms{kRadius, zernike_modes(1, 4), {}, {}};
  SurfaceOperator surface;
  Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(terms.size());

  explicit Scene(bool waves = true)
      : pupil(waves ? diffraction_pupil(aperture, kFocalLength, 2 * kRadius / 128).sample
                    : make_pupil(aperture, {PupilLayout::kSobol, 20000, 3})),
        surface(terms, pupil, {1, {}, {}, waves}) {}

  void set(ZernikeMode mode, double height) {
    for (std::size_t k = 0; k < terms.zernike.size(); ++k)
      if (terms.zernike[k].n == mode.n && terms.zernike[k].m == mode.m)
        coefficients[Eigen::Index(k)] = height;
  }
  std::unique_ptr<FocalLight> light(FocusModel model) const {
    return surface_light({mirror, pupil, surface, model, kWavelength, &aperture}, coefficients, 2);
  }
  FocusArrays arrays(const FocalLight* theory, const FocalLight* own, std::vector<double> planes = {}) const {
    return make_focus_arrays(
        {theory, own, mirror, aperture, kWavelength, std::move(planes), 0.6 * kUnit, "a title"});
  }
};

double pixel_area(const FocusArrays& arrays) { return std::pow(arrays.pixel[1] - arrays.pixel[0], 2); }

TEST(FocusArrays, OfAPerfectMirrorAreThoseOfAiry) {
  const Scene scene;
  const auto light = scene.light(FocusModel::kWaves);
  const FocusArrays arrays = scene.arrays(nullptr, light.get());
  ASSERT_TRUE(arrays.surface && !arrays.theory);
  ASSERT_EQ(arrays.plane.size(), 1);
  const LightArrays& own = *arrays.surface;
  for (Eigen::Index k = 0; k < arrays.radius.size(); k += 25)
    EXPECT_NEAR(own.encircled_energy(0, k), airy_share(arrays.radius[k]), 2e-5) << arrays.radius[k] / kUnit;
  // A ring has 1/500 of the radius of the curve; within it the irradiance bends by 1e-4 of the peak.
  for (Eigen::Index k = 5; k + 1 < arrays.radius.size(); k += 25)
    EXPECT_NEAR(own.ring_profile(0, k), airy_irradiance(0.5 * (arrays.radius[k] + arrays.radius[k + 1])),
                1e-4 * airy_irradiance(1e-9))
        << k;
  const double half = 0.5 * double(arrays.pixel.size()) * (arrays.pixel[1] - arrays.pixel[0]);
  EXPECT_LE(arrays.pixel[1] - arrays.pixel[0], 0.5 * kUnit);
  EXPECT_NEAR(own.psf.sum() * pixel_area(arrays), share_in_square(half, airy_share), 1e-3);
  // The middle pixel has the peak irradiance less its curvature over the pixel.
  const Eigen::Index middle = arrays.pixel.size() / 2;
  EXPECT_NEAR(arrays.pixel[middle], 0, 1e-12 * half);
  EXPECT_NEAR(own.psf(middle, middle) / airy_irradiance(1e-9), 1, 0.02);
}

TEST(FocusArrays, TheTransferFunctionOfACircleIsGoodmans) {
  const Scene scene;
  const auto light = scene.light(FocusModel::kWaves);
  const FocusArrays arrays = scene.arrays(nullptr, light.get());
  ASSERT_TRUE(arrays.surface->otf);
  const TransferImage& otf = *arrays.surface->otf;
  ASSERT_EQ(arrays.frequency.size(), otf.middle + 1);
  EXPECT_NEAR(arrays.frequency[otf.middle] / kCutoff, 1, 0.02);
  double worst = 0;
  for (Eigen::Index row = 0; row < otf.value.rows(); ++row)
    for (Eigen::Index column = 0; column < otf.value.cols(); ++column) {
      const double frequency = otf.step * std::hypot(double(row - otf.middle), double(column - otf.middle));
      worst = std::max(worst, std::abs(otf.value(row, column) - circle_mtf(frequency)));
    }
  // The error comes from grid points at the edge, with 128 across; the amplitudes take them to third order in
  // the pitch.
  EXPECT_LT(worst, 2e-4);
  RecordProperty("worst", std::to_string(worst));
  EXPECT_EQ(otf.value(otf.middle, otf.middle), 1.0);
}

// A tilted mirror moves the spot to where its rays go, in pixels, rows, columns and the phase of the OTF.
TEST(FocusArrays, AxesPointWhereRaysGo) {
  for (const int m : {1, -1}) {
    Scene scene, traced(false);
    for (Scene* each : {&scene, &traced}) each->set({1, m}, 40e-9);
    SurfaceField field;
    traced.surface.apply(traced.coefficients, &field);
    const RayBundle rays = trace(traced.mirror, traced.pupil, field);
    const double x = (rays.weight * rays.x).sum() / rays.weight.sum();
    const double y = (rays.weight * rays.y).sum() / rays.weight.sum();
    ASSERT_GT(std::abs(m > 0 ? x : y), 0.3 * kUnit);
    ASSERT_LT(std::abs(m > 0 ? y : x), 1e-3 * kUnit);

    const auto light = scene.light(FocusModel::kWaves);
    const FocusArrays arrays = scene.arrays(nullptr, light.get());
    const Eigen::ArrayXXd& psf = arrays.surface->psf;
    Eigen::Index row = 0, column = 0;
    psf.maxCoeff(&row, &column);
    const double pixel = arrays.pixel[1] - arrays.pixel[0];
    EXPECT_NEAR(arrays.pixel[column], x, 0.51 * pixel);
    EXPECT_NEAR(arrays.pixel[row], y, 0.51 * pixel);
    const TransferImage& otf = *arrays.surface->otf;
    const Eigen::Index at = otf.middle + 20;
    EXPECT_NEAR(std::arg(otf.value(otf.middle, at)),
                std::remainder(-2 * std::numbers::pi * 20 * otf.step * x, 2 * std::numbers::pi), 1e-3);
    EXPECT_NEAR(std::arg(otf.value(at, otf.middle)),
                std::remainder(-2 * std::numbers::pi * 20 * otf.step * y, 2 * std::numbers::pi), 1e-3);
  }
}

// The transfer function of an aberrated spot equals that of an image with pixels of a quarter of lambda F.
TEST(FocusArrays, TheTransferFunctionIsThatOfThePattern) {
  Scene scene;
  scene.set({2, 2}, 60e-9);
  scene.set({3, 1}, 50e-9);
  const DiffractionPupil pupil = diffraction_pupil(scene.aperture, kFocalLength, 2 * kRadius / 128);
  SurfaceField field;
  scene.surface.apply(scene.coefficients, &field);
  const PsfImage whole = diffraction_psf({pupil, kFocalLength, kWavelength}, field.height, {});
  const auto light = scene.light(FocusModel::kWaves);
  const TransferImage otf = *light->transfer();
  for (const auto& [down, across] :
       {std::pair(0, 1), std::pair(3, 40), std::pair(-25, 10), std::pair(60, -60)}) {
    std::complex<double> sum = 0;
    for (Eigen::Index j = 0; j < whole.intensity.rows(); ++j)
      for (Eigen::Index i = 0; i < whole.intensity.cols(); ++i)
        sum += whole.intensity(j, i) * std::polar(1.0, -2 * std::numbers::pi * otf.step *
                                                           (across * (whole.first + double(i) * whole.pitch) +
                                                            down * (whole.first + double(j) * whole.pitch)));
    sum *= whole.pitch * whole.pitch;
    EXPECT_LT(std::abs(otf.value(otf.middle + down, otf.middle + across) - sum), 1e-11)
        << down << ' ' << across;
  }
}

// The theory is sigma^2 exp of the autocorrelation of a uniform band, in closed form.
TEST(FocusArrays, OfTheoryAreHarveyShacks) {
  constexpr double rms = 60e-9, low = 5, high = 60;
  const Scene scene;
  const auto spot = std::make_shared<const GeneralisedHarveyShack>(RadialPsd(UniformPsd{rms, low, high}),
                                                                   scene.mirror, scene.aperture, kWavelength);
  const auto light = mean_light(spot, kWavelength * kFocalLength, 2);
  const FocusArrays arrays = scene.arrays(light.get(), nullptr, {0.02, -0.02});
  ASSERT_TRUE(arrays.theory && !arrays.surface && arrays.theory->mtf);
  ASSERT_EQ(arrays.plane.size(), 3);
  EXPECT_EQ(arrays.plane[0], -0.02);
  EXPECT_EQ(arrays.plane[2], 0.02);
  for (const Eigen::Index k : {Eigen::Index(0), Eigen::Index(2)})
    EXPECT_NEAR(arrays.theory->encircled_energy(k, 100),
                spot->encircled_energy(arrays.radius[100], arrays.plane[k]), 1e-12);
  const double g = 4 * std::numbers::pi * rms / kWavelength;
  for (Eigen::Index k = 1; k < arrays.frequency.size(); k += 10) {
    const double x = kWavelength * kFocalLength * arrays.frequency[k], turn = 2 * std::numbers::pi * x;
    const auto edge = [&](double f) { return f * boost::math::cyl_bessel_j(1, turn * f) / x; };
    const double correlation = (edge(high) - edge(low)) / (std::numbers::pi * (high * high - low * low));
    EXPECT_NEAR((*arrays.theory->mtf)[k],
                circle_mtf(arrays.frequency[k]) * std::exp(-g * g * (1 - correlation)), 2e-5)
        << k;
  }
  const double half = 0.5 * double(arrays.pixel.size()) * (arrays.pixel[1] - arrays.pixel[0]);
  const double inside = share_in_square(half, [&](double r) { return spot->encircled_energy(r, 0); });
  EXPECT_LT(inside, 0.99);
  EXPECT_NEAR(arrays.theory->psf.sum() * pixel_area(arrays), inside, 1e-3);
}

// The spot of rays is exactly Gaussian, so Rayleigh's law holds within the error of 20,000 rays.
TEST(FocusArrays, OfRaysAreCountedAndHaveNoTransferFunction) {
  const Scene scene(false);
  RayBundle rays = trace_nominal(scene.mirror, scene.pupil);
  const RayBundle nominal = rays;
  const double sigma = 0.6 * kUnit;
  const RandomStream random(7, "focus-arrays");
  for (Eigen::Index i = 0; i < rays.size(); ++i) {
    const auto [a, b] = random.normal_pair(std::uint64_t(i));
    rays.x[i] += sigma * a;
    rays.y[i] += sigma * b;
  }
  const auto light = ray_light(rays, nominal, Centre::kNominal);
  const FocusArrays arrays = scene.arrays(light.get(), light.get());
  for (Eigen::Index k = 0; k < arrays.radius.size(); k += 50) {
    const double share = -std::expm1(-0.5 * std::pow(arrays.radius[k] / sigma, 2));
    EXPECT_NEAR(arrays.surface->encircled_energy(0, k), share,
                4 * std::sqrt(share * (1 - share) / 20000) + 1e-9);
  }
  const double half = 0.5 * double(arrays.pixel.size()) * (arrays.pixel[1] - arrays.pixel[0]);
  const double inside = std::pow(std::erf(half / (sigma * std::numbers::sqrt2)), 2);
  EXPECT_NEAR(arrays.surface->psf.sum() * pixel_area(arrays), inside, 1e-3);
  EXPECT_EQ(arrays.frequency.size(), 0);
  EXPECT_FALSE(arrays.surface->otf || arrays.theory->mtf);
  const auto names = [&](ArrayFormat format) {
    std::string all;
    for (const auto& [name, content] : array_files(format, arrays)) all += name + " ";
    return all;
  };
  EXPECT_EQ(names(ArrayFormat::kNone), "");
  EXPECT_EQ(names(ArrayFormat::kFits), "psf.fits ");
  EXPECT_EQ(
      names(ArrayFormat::kCsv),
      "arrays/encircled_energy.csv arrays/ring_profile.csv arrays/psf_theory.csv arrays/psf_surface.csv ");
}

// A surface by waves and its theory, computed once.
const FocusArrays& both() {
  static const FocusArrays arrays = [] {
    Scene scene;
    scene.set({2, 2}, 60e-9);
    scene.set({3, -1}, 40e-9);
    const auto surface = scene.light(FocusModel::kWaves);
    const auto theory =
        mean_light(std::make_shared<const GeneralisedHarveyShack>(RadialPsd(UniformPsd{40e-9, 5, 20}),
                                                                  scene.mirror, scene.aperture, kWavelength),
                   kWavelength * kFocalLength, 2);
    return scene.arrays(theory.get(), surface.get(), {0.01});
  }();
  return arrays;
}

std::string content_of(ArrayFormat format, const std::string& wanted) {
  for (const auto& [name, content] : array_files(format, both()))
    if (name == wanted) return content;
  ADD_FAILURE() << "no " << wanted;
  return {};
}

template <typename Values>
void expect_same(const std::vector<double>& read, const Values& written) {
  ASSERT_EQ(read.size(), std::size_t(written.size()));
  for (Eigen::Index row = 0; row < written.rows(); ++row)
    for (Eigen::Index column = 0; column < written.cols(); ++column)
      ASSERT_EQ(read[std::size_t(row * written.cols() + column)], written(row, column));
}

TEST(Npz, EveryBitOfEveryShapeComesBack) {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<NpyArray> all = {
      {"number_m", {}, {-0.0}},
      {"line", {5}, {1.0 / 3, std::nan(""), infinity, -infinity, 5e-324}},
      {"none", {0}, {}},
      {"grid", {2, 3}, {1, 2, 3, 4, 5, 6}},
      {"a_name_so_long_that_a_header_of_sixty_four_bytes_would_not_do_if_it_were_in_it", {1, 1, 2}, {7, 8}}};
  std::vector<std::pair<std::string, std::string>> members;
  for (const NpyArray& array : all) members.emplace_back(array.name + ".npy", internal::npy_bytes(array));
  const NpzReader reader(internal::stored_zip(members));
  ASSERT_EQ(reader.arrays().size(), all.size());
  for (const NpyArray& array : all) {
    SCOPED_TRACE(array.name);
    const test::LoadedArray& read = reader.at(array.name);
    EXPECT_EQ(read.shape, std::vector<std::size_t>(array.shape.begin(), array.shape.end()));
    ASSERT_EQ(read.values.size(), array.values.size());
    for (std::size_t k = 0; k < array.values.size(); ++k)
      EXPECT_EQ(std::bit_cast<std::uint64_t>(read.values[k]), std::bit_cast<std::uint64_t>(array.values[k]));
  }
  EXPECT_EQ(internal::crc32_of("123456789"), 0xCBF43926u);  // the check value that every table of CRCs has
}

TEST(FocusArrays, NpzHoldsThemAll) {
  const FocusArrays& arrays = both();
  const NpzReader npz(content_of(ArrayFormat::kNpz, "arrays.npz"));
  EXPECT_EQ(npz.at("wavelength_m").values, std::vector<double>{kWavelength});
  EXPECT_TRUE(npz.at("wavelength_m").shape.empty());
  expect_same(npz.at("plane_dz_m").values, arrays.plane);
  expect_same(npz.at("ee_radius_m").values, arrays.radius);
  EXPECT_EQ(npz.at("ee_theory").shape, (std::vector<std::size_t>{2, std::size_t(arrays.radius.size())}));
  expect_same(npz.at("ee_theory").values, arrays.theory->encircled_energy);
  expect_same(npz.at("ee_surface").values, arrays.surface->encircled_energy);
  expect_same(npz.at("ring_surface_per_m2").values, arrays.surface->ring_profile);
  EXPECT_EQ(npz.at("ring_radius_m").values.size() + 1, std::size_t(arrays.radius.size()));
  expect_same(npz.at("psf_x_m").values, arrays.pixel);
  expect_same(npz.at("psf_theory_per_m2").values, arrays.theory->psf);
  expect_same(npz.at("psf_surface_per_m2").values, arrays.surface->psf);
  const TransferImage& otf = *arrays.surface->otf;
  expect_same(npz.at("otf_surface_real").values, Eigen::ArrayXXd(otf.value.real()));
  expect_same(npz.at("otf_surface_imag").values, Eigen::ArrayXXd(otf.value.imag()));
  expect_same(npz.at("mtf_frequency_per_m").values, arrays.frequency);
  expect_same(npz.at("mtf_theory").values, *arrays.theory->mtf);
  const std::size_t middle = std::size_t(otf.middle);
  for (std::size_t k = 0; k <= middle; k += 7) {
    const auto step = Eigen::Index(k);
    EXPECT_EQ(npz.at("otf_fx_per_m").values[middle + k], npz.at("mtf_frequency_per_m").values[k]);
    EXPECT_EQ(npz.at("mtf_surface_x").values[k], std::abs(otf.value(otf.middle, otf.middle + step)));
    EXPECT_EQ(npz.at("mtf_surface_y").values[k], std::abs(otf.value(otf.middle + step, otf.middle)));
  }
}

TEST(FocusArrays, NumpyLoadsTheNpz) {
  const std::string python = ABERFIT_PYTHON3;
  if (std::system((python + " -c 'import numpy' > /dev/null 2>&1").c_str()) != 0)
    GTEST_SKIP() << "no NumPy for " << python;
  const test::ScratchFolder folder;
  folder.write("arrays.npz", content_of(ArrayFormat::kNpz, "arrays.npz"));
  folder.write("look.py",
               "import numpy, sys\n"
               "a = numpy.load(sys.argv[1])\n"
               "for n in sorted(a.files):\n"
               "  v = a[n]\n"
               "  assert v.dtype == numpy.float64 and v.flags.c_contiguous, n\n"
               "  print(n, v.ndim, v.size, repr(float(v.flat[v.size // 3])))\n");
  ASSERT_EQ(std::system((python + " '" + folder.file("look.py") + "' '" + folder.file("arrays.npz") +
                         "' > '" + folder.file("seen.txt") + "'")
                            .c_str()),
            0);
  std::istringstream seen(test::read_file(folder.file("seen.txt")));
  std::string name;
  std::size_t axes = 0, size = 0, count = 0;
  const NpzReader npz(test::read_file(folder.file("arrays.npz")));
  for (double value = 0; seen >> name >> axes >> size >> value; ++count) {
    EXPECT_EQ(npz.at(name).shape.size(), axes) << name;
    EXPECT_EQ(npz.at(name).values.size(), size) << name;
    EXPECT_EQ(npz.at(name).values[size / 3], value) << name;
  }
  EXPECT_EQ(count, npz.arrays().size());
}

// A table as a spreadsheet reads it: comments, column names if there are any, numbers.
struct Table {
  std::vector<std::string> names;
  std::vector<double> values;
  std::size_t rows = 0;
};
Table read_table(const std::string& text, bool has_names) {
  Table table;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream cells(line);
    const bool names = has_names && table.names.empty();
    for (std::string cell; std::getline(cells, cell, ',');) {
      if (names)
        table.names.push_back(cell);
      else
        table.values.push_back(std::stod(cell));
    }
    if (!names) ++table.rows;
  }
  return table;
}

TEST(FocusArrays, CsvTablesHoldThemToTheLastBit) {
  const FocusArrays& arrays = both();
  const Table ee = read_table(content_of(ArrayFormat::kCsv, "arrays/encircled_energy.csv"), true);
  EXPECT_EQ(ee.names, (std::vector<std::string>{"plane_dz_m", "radius_m", "theory", "surface"}));
  const auto radii = std::size_t(arrays.radius.size());
  ASSERT_EQ(ee.rows, 2 * radii);
  for (std::size_t row = 0; row < ee.rows; row += 17) {
    const auto plane = Eigen::Index(row / radii), k = Eigen::Index(row % radii);
    EXPECT_EQ(ee.values[4 * row], arrays.plane[plane]);
    EXPECT_EQ(ee.values[4 * row + 1], arrays.radius[k]);
    EXPECT_EQ(ee.values[4 * row + 2], arrays.theory->encircled_energy(plane, k));
    EXPECT_EQ(ee.values[4 * row + 3], arrays.surface->encircled_energy(plane, k));
  }
  const Table ring = read_table(content_of(ArrayFormat::kCsv, "arrays/ring_profile.csv"), true);
  EXPECT_EQ(ring.names[3], "surface_per_m2");
  EXPECT_EQ(ring.values[4 * (radii - 1) + 3], arrays.surface->ring_profile(1, 0));
  const Table mtf = read_table(content_of(ArrayFormat::kCsv, "arrays/mtf.csv"), true);
  EXPECT_EQ(mtf.names, (std::vector<std::string>{"frequency_per_m", "theory", "surface_x", "surface_y"}));
  EXPECT_EQ(mtf.rows, std::size_t(arrays.frequency.size()));
  EXPECT_EQ(mtf.values[4 * 9 + 1], (*arrays.theory->mtf)[9]);
  expect_same(read_table(content_of(ArrayFormat::kCsv, "arrays/psf_surface.csv"), false).values,
              arrays.surface->psf);
  expect_same(read_table(content_of(ArrayFormat::kCsv, "arrays/otf_surface_imag.csv"), false).values,
              Eigen::ArrayXXd(arrays.surface->otf->value.imag()));
}

TEST(FocusArrays, FitsHasTheKeysThatOtherProgramsLookFor) {
  const FocusArrays& arrays = both();
  const auto psf = read_fits_units(content_of(ArrayFormat::kFits, "psf.fits"));
  ASSERT_EQ(psf.size(), 2u);
  const double pixel = arrays.pixel[1] - arrays.pixel[0], arcsec = std::numbers::pi / (180 * 3600);
  for (const auto& unit : psf) {
    EXPECT_EQ(unit.keys.at("BUNIT"), "m-2");
    EXPECT_EQ(unit.keys.at("OBJECT"), "a title");
    EXPECT_NEAR(unit.number("PIXELSCL") * arcsec, pixel / kFocalLength, 1e-15 * pixel);
    EXPECT_EQ(unit.keys.at("PIXUNIT"), "arcsecond");
    EXPECT_NEAR(unit.number("WAVELEN"), kWavelength, 1e-20);
    EXPECT_NEAR(unit.number("DIAM"), 2 * kRadius, 1e-15);
    EXPECT_NEAR(unit.number("DIFFLMT") * arcsec, kWavelength / (2 * kRadius), 1e-18);
    EXPECT_EQ(unit.number("PLANE_DZ"), 0);
    for (const char axis : {'1', '2'}) {
      const auto key = [&](const std::string& name) { return name + axis; };
      EXPECT_EQ(unit.keys.at(key("CTYPE")), axis == '1' ? "X" : "Y");
      EXPECT_EQ(unit.keys.at(key("CUNIT")), "m");
      // The coordinate of the first pixel, as the standard counts them.
      EXPECT_NEAR(unit.number(key("CRVAL")) + (1 - unit.number(key("CRPIX"))) * unit.number(key("CDELT")),
                  arrays.pixel[0], 1e-12 * std::abs(arrays.pixel[0]));
    }
    double sum = 0;
    for (const double value : unit.values) sum += value;
    const bool theory = unit.keys.at("LIGHT") == "theory";
    EXPECT_NEAR(sum * unit.number("PIXAREA"),
                (theory ? arrays.theory : arrays.surface)->psf.sum() * pixel * pixel, 1e-12);
  }
  expect_same(psf[0].values, arrays.surface->psf);
  expect_same(psf[1].values, arrays.theory->psf);
  EXPECT_EQ(psf[1].keys.at("EXTNAME"), "THEORY");
}

// This program's own readers read the exported FITS files: solve.focus reads the image, and transfer
// functions are compared pixel by pixel.
TEST(FocusArrays, FitsIsReadBackAsItWasWritten) {
  const FocusArrays& arrays = both();
  const test::ScratchFolder folder;
  const FocalImage image =
      read_focal_image(folder.write("psf.fits", content_of(ArrayFormat::kFits, "psf.fits")));
  EXPECT_TRUE(image.is_angle);
  const double pixel = arrays.pixel[1] - arrays.pixel[0];
  EXPECT_NEAR(image.pixel * kFocalLength, pixel, 1e-14 * pixel);
  EXPECT_TRUE((image.light == arrays.surface->psf).all());
  const Grid otf = read_mask(folder.write("otf.fits", content_of(ArrayFormat::kFits, "otf.fits")));
  EXPECT_TRUE((otf == arrays.surface->otf->value.abs()).all());
}

// We do not compare with the written arrays, but with the theory: sum times area is the energy in the square.
TEST(FocusArrays, FitsHoldsTheLightOfItsSquare) {
  const auto psf = read_fits_units(content_of(ArrayFormat::kFits, "psf.fits"));
  const GeneralisedHarveyShack spot(RadialPsd(UniformPsd{40e-9, 5, 20}), Mirror{kFocalLength, -1, {}},
                                    CircleAperture{2 * kRadius, 0}, kWavelength);
  double sum = 0;
  for (const double value : psf.at(1).values) sum += value;
  const double half = 0.5 * double(psf[1].columns) * psf[1].number("CDELT1");
  EXPECT_NEAR(sum * psf[1].number("CDELT1") * psf[1].number("CDELT2"),
              share_in_square(half, [&](double r) { return spot.encircled_energy(r, 0); }), 1e-3);
}

TEST(FocusArrays, FitsHasTheTransferFunctionWithItsParts) {
  const FocusArrays& arrays = both();
  const TransferImage& image = *arrays.surface->otf;
  const auto otf = read_fits_units(content_of(ArrayFormat::kFits, "otf.fits"));
  ASSERT_EQ(otf.size(), 4u);
  expect_same(otf[0].values, Eigen::ArrayXXd(image.value.abs()));
  EXPECT_EQ(otf[1].keys.at("EXTNAME"), "REAL");
  EXPECT_EQ(otf[2].keys.at("EXTNAME"), "IMAG");
  expect_same(otf[1].values, Eigen::ArrayXXd(image.value.real()));
  expect_same(otf[2].values, Eigen::ArrayXXd(image.value.imag()));
  EXPECT_EQ(otf[0].keys.at("CUNIT1"), "m-1");
  EXPECT_NEAR(otf[0].number("CDELT1"), image.step, 1e-14 * image.step);
  EXPECT_EQ(otf[0].number("CRPIX1"), double(image.middle + 1));
  EXPECT_EQ(otf[3].keys.at("NAXIS"), "1");
  EXPECT_EQ(otf[3].number("CRPIX1"), 1);
  expect_same(otf[3].values, *arrays.theory->mtf);
}

}  // namespace
}  // namespace aberfit
