// Wave-optics statistics of a map, of its terms, and of the terms with the residual's PSD. References: sums
// over a polar pupil, small-aberration formulas, and random surfaces of a known roughness.
#include "aberfit/method/map_light.h"

#include <gtest/gtest.h>

#include <complex>
#include <functional>
#include <iostream>

#include "aberfit/core/constants.h"
#include "aberfit/core/random.h"
#include "aberfit/method/measured_part.h"
#include "aberfit/roughness/random_surface.h"
#include "aberfit/theory/realisation_spread.h"
#include "short_form.h"

namespace aberfit {
namespace {

constexpr double kDiameter = 50e-3, kFocalLength = 1.0, kWavelength = 632.8e-9;
constexpr double kRadius = kDiameter / 2;
constexpr int kAcross = 160;
// Error of the grid: an edge of 160 cells, and f/20 in a paraxial pupil. The largest error seen is 3e-5.
constexpr double kGridError = 1e-4;

Task scene() {
  Task task;
  task.mirror.focal_length = kFocalLength;
  task.aperture = CircleAperture{kDiameter, 0};
  task.wavelength = kWavelength;
  return task;
}

using Surface = std::function<double(double x, double y)>;

// Points of a round part, with the rim in the middle of the outermost pixels.
HeightMap map_of(const Surface& height, int across = kAcross) {
  HeightMap map;
  map.pitch_x = map.pitch_y = kDiameter / across;
  map.height = Grid::Constant(across + 1, across + 1, kNaN);
  centre_on_grid(&map);
  for (Eigen::Index row = 0; row < map.rows(); ++row)
    for (Eigen::Index column = 0; column < map.columns(); ++column)
      if (std::hypot(map.x(column), map.y(row)) <= kRadius * (1 + 1e-9))
        map.height(row, column) = height(map.x(column), map.y(row));
  return map;
}

struct Lit {
  TermSet terms;
  MapFitResult fit;
  MapPanels panels;
  MapLight light;
};

Lit light_of(const HeightMap& map, int order, const Task& task = scene(), bool with_ring = false) {
  Lit lit;
  lit.terms.radius = kRadius;
  lit.terms.zernike = zernike_modes(2, order);
  lit.fit = fit_map(map, lit.terms);
  lit.panels = map_panels(map, task.aperture, lit.terms, lit.fit, 2);
  lit.light = map_light(task, lit.panels, lit.terms, lit.fit, with_ring, 2);
  return lit;
}

// RMS height of every term, orthonormal on the disc; the polynomials are written anew.
struct LowOrder {
  double defocus, coma, astigmatism;

  double operator()(double x, double y) const {
    const double rho2 = (x * x + y * y) / (kRadius * kRadius);
    return defocus * std::sqrt(3.0) * (2 * rho2 - 1) + coma * std::sqrt(8.0) * (3 * rho2 - 2) * x / kRadius +
           astigmatism * std::sqrt(6.0) * (x * x - y * y) / (kRadius * kRadius);
  }
  double rms() const { return std::sqrt(defocus * defocus + coma * coma + astigmatism * astigmatism); }
};

// The pattern by direct sums over rings of the pupil, without grid or transform.
class DirectSum {
 public:
  explicit DirectSum(const Surface& height) {
    constexpr int kSpokes = 128;
    for (const RadialNode& node : radial_quadrature(CircleAperture{kDiameter, 0}, 48))
      for (int j = 0; j < kSpokes; ++j) {
        const double angle = 2 * kPi * (j + 0.5) / kSpokes;
        const double x = node.rho * std::cos(angle), y = node.rho * std::sin(angle);
        x_.push_back(x), y_.push_back(y);
        // The path is twice the height.
        wave_.push_back(std::polar(node.weight / kSpokes, -2 * kPi / kWavelength * 2 * height(x, y)));
      }
  }
  // Irradiance over the focal peak of the pupil with zero height.
  double operator()(double x, double y) const {
    std::complex<double> sum = 0;
    const double k = -2 * kPi / (kWavelength * kFocalLength);
    for (std::size_t i = 0; i < wave_.size(); ++i)
      sum += wave_[i] * std::polar(1.0, k * (x_[i] * x + y_[i] * y));
    return std::norm(sum);
  }
  double highest() const {
    const double step = kWavelength * kFocalLength / kDiameter / 16;
    double best = 0;
    for (int i = -24; i <= 24; ++i)
      for (int j = -4; j <= 4; ++j) best = std::max(best, (*this)(i * step, j * step));
    return best;
  }
  // Energy fraction within a radius. The peak of the flat pupil is area/(lambda f)^2 of the total energy.
  double share(double radius) const {
    constexpr int kSpokes = 24;
    double sum = 0;
    for (const RadialNode& node : radial_quadrature(CircleAperture{2 * radius, 0}, 12))
      for (int j = 0; j < kSpokes; ++j) {
        const double angle = 2 * kPi * (j + 0.5) / kSpokes;
        sum += node.weight / kSpokes * (*this)(node.rho * std::cos(angle), node.rho * std::sin(angle));
      }
    const double pupil = kPi * kRadius * kRadius, disc = kPi * radius * radius;
    return sum * pupil * disc / std::pow(kWavelength * kFocalLength, 2);
  }

 private:
  std::vector<double> x_, y_;
  std::vector<std::complex<double>> wave_;
};

int count_of(const Warnings& warnings, const std::string& code) {
  return int(
      std::count_if(warnings.begin(), warnings.end(), [&](const Warning& w) { return w.code == code; }));
}

// exp(-(2 pi sigma)^2), with sigma the RMS wave aberration in waves, twice that of the surface (Mahajan
// 1983). For 0.2 rad its error is a few percent of the loss squared.
TEST(MapLight, StrehlOfSmallAberrationsIsThatOfTheirRms) {
  for (const LowOrder& error : {LowOrder{6e-9, 0, 0}, LowOrder{0, 8e-9, 0}, LowOrder{5e-9, -6e-9, 4e-9}}) {
    const LitSurface lit = light_of(map_of(error), 4).light.measured;
    const double loss = std::pow(2 * kPi * 2 * error.rms() / kWavelength, 2);
    ASSERT_GT(loss, 0.01);
    EXPECT_NEAR(lit.strehl, std::exp(-loss), loss * loss + kGridError);
    EXPECT_GT(std::abs(std::exp(-loss) - std::exp(-loss / 4)), 10 * (loss * loss + kGridError));  // OPD = h
  }
}

TEST(MapLight, IsADirectSumOverThePupil) {
  const LowOrder error{35e-9, 45e-9, -25e-9};
  const DirectSum direct(error);
  const LitSurface lit = light_of(map_of(error), 4).light.measured;
  EXPECT_NEAR(lit.strehl, direct.highest(), 2e-3);  // samples are a sixteenth of lambda f/D apart
  EXPECT_LT(lit.strehl, 0.4);
  EXPECT_NEAR(direct.share(lit.ee50), 0.5, kGridError);
  EXPECT_NEAR(direct.share(lit.ee80), 0.8, kGridError);
  // The image has the right orientation: coma points along x with the sign of the surface.
  const double at = 0.6 * kWavelength * kFocalLength / kDiameter;
  const auto sample = [&](double x, double y) {
    const auto k = [&](double v) { return std::lround((v - lit.psf.first) / lit.psf.pitch); };
    return std::pair{lit.psf.intensity(k(y), k(x)), direct(lit.psf.first + double(k(x)) * lit.psf.pitch,
                                                           lit.psf.first + double(k(y)) * lit.psf.pitch)};
  };
  for (const auto& [x, y] : {std::pair{at, 0.0}, {-at, 0.0}, {0.0, at}, {2 * at, 0.0}}) {
    const auto [ours, truth] = sample(x, y);
    EXPECT_NEAR(ours, truth, kGridError) << x << ' ' << y;
  }
  EXPECT_GT(std::abs(sample(at, 0).second - sample(-at, 0).second), 100 * kGridError);
}

TEST(MapLight, PerfectMirrorHasTheAiryPattern) {
  const LitSurface lit = light_of(map_of(LowOrder{5e-9, 0, 0}), 4).light.perfect;
  const double unit = kWavelength * kFocalLength / kDiameter;
  EXPECT_NEAR(lit.strehl, 1, 1e-12);
  // EE(r) = 1 - J0^2 - J1^2 of v = pi r/unit (Born and Wolf, 8.5.2).
  const auto share = [&](double radius) {
    const double v = kPi * radius / unit;
    return 1 - std::pow(std::cyl_bessel_j(0, v), 2) - std::pow(std::cyl_bessel_j(1, v), 2);
  };
  EXPECT_NEAR(share(lit.ee50), 0.5, kGridError);
  EXPECT_NEAR(share(lit.ee80), 0.8, kGridError);
  EXPECT_NEAR(share(lit.ee90), 0.9, kGridError);
}

TEST(MapLight, TermsAreTheMapWhereTheMapIsTerms) {
  const Lit lit = light_of(map_of(LowOrder{20e-9, 30e-9, 10e-9}), 4, scene(), true);
  const MapLight& light = lit.light;
  EXPECT_LT(lit.panels.residual.rms, 1e-17);
  EXPECT_EQ(light.rest.rms_height, 0);
  EXPECT_TRUE(light.rest.obstacle.empty());
  EXPECT_TRUE(light.warnings.empty());
  EXPECT_GT(light.ring_fwhm, 0);
  for (const LitSurface* other : {&light.measured, &light.terms_and_rest}) {
    EXPECT_NEAR(other->strehl, light.terms.strehl, 1e-9);
    EXPECT_NEAR(other->ee90 / light.terms.ee90, 1, 1e-9);
    EXPECT_NEAR((other->share - light.terms.share).abs().maxCoeff(), 0, 1e-9);
  }
  const Eigen::ArrayXd& radius = light.radius;
  const auto beyond = std::lower_bound(radius.begin(), radius.end(), light.terms.ee80) - radius.begin();
  EXPECT_LT(light.terms.share[beyond - 1], 0.8);
  EXPECT_GE(light.terms.share[beyond], 0.8);
}

// Piston and tilt belong to the mount and do not move the image, unless the terms include them.
TEST(MapLight, LeavesOutPistonAndTiltOfTheMount) {
  const LowOrder error{20e-9, 30e-9, 10e-9};
  const Lit plain = light_of(map_of(error), 4);
  const Lit tilted = light_of(map_of([&](double x, double y) {
                                return error(x, y) + 3e-6 + 4e-6 * x / kRadius - 2e-6 * y / kRadius;
                              }),
                              4);
  EXPECT_NEAR(tilted.light.measured.strehl, plain.light.measured.strehl, 1e-6);
  EXPECT_NEAR(tilted.light.measured.ee90 / plain.light.measured.ee90, 1, 1e-6);
  EXPECT_NEAR(tilted.panels.measured.rms / plain.panels.measured.rms, 1, 1e-6);
  EXPECT_NEAR(tilted.fit.mount.slope_x, 4e-6 / kRadius, 1e-9 * 4e-6 / kRadius);
  EXPECT_NEAR(tilted.fit.mount.slope_y, -2e-6 / kRadius, 1e-9 * 4e-6 / kRadius);
  EXPECT_NEAR(tilted.fit.mount.height, 3e-6, 1e-14);
}

// A hole in the data is none in the mirror. If opaque, holes in 3 % of the points would scatter 3 %.
TEST(MapLight, HolesHaveTheHeightOfTheTerms) {
  const LowOrder error{20e-9, 30e-9, 10e-9};
  const HeightMap whole = map_of(error);
  HeightMap holes = whole;
  const RandomStream stream(1, "map-light-holes");
  double inside = 0, dropped = 0;
  for (Eigen::Index at = 0; at < holes.height.size(); ++at) {
    double& height = holes.height.data()[at];
    if (!std::isfinite(height)) continue;
    ++inside;
    if (stream.uniform(std::uint64_t(at)) < 0.03) height = kNaN, ++dropped;
  }
  const Lit lit = light_of(holes, 4), of_whole = light_of(whole, 4);
  EXPECT_NEAR(lit.light.filled_share, dropped / inside, 2e-3);
  EXPECT_EQ(of_whole.light.filled_share, 0);
  EXPECT_EQ(lit.light.cells, of_whole.light.cells);
  EXPECT_NEAR(lit.light.measured.strehl, of_whole.light.measured.strehl, 1e-6);
  EXPECT_NEAR(lit.light.measured.ee90 / of_whole.light.measured.ee90, 1, 1e-6);
  EXPECT_EQ(valid_count(lit.panels.residual.map), Eigen::Index(inside - dropped));  // left blank in the panel
  EXPECT_EQ(count_of(lit.light.warnings, "map-filled"), 0);

  // A missing part of the rim, and points of another mount: the grid need not cover the aperture.
  HeightMap bitten = whole;
  const Eigen::Index kept = whole.columns() * 85 / 100;
  bitten.height = Grid(whole.height.leftCols(kept));
  const Lit part = light_of(bitten, 4);
  EXPECT_EQ(count_of(part.light.warnings, "map-filled"), 1);
  EXPECT_EQ(part.light.cells, of_whole.light.cells);
  EXPECT_NEAR(part.light.measured.ee90 / of_whole.light.measured.ee90, 1, 1e-6);
}

// Terms and a roughness of known PSD.
struct RoughPart {
  static constexpr double kFirst = 250, kLast = 1400;  // [cycles/m]; the map ends at 1600
  static RadialPsd psd(double rms) { return RadialPsd(KCorrelationPsd{rms, 2e-3, 2.5, kFirst, kLast}); }
  static HeightMap map(double rms, std::uint64_t seed, const LowOrder& error) {
    const HeightMap rough =
        random_surface(psd(rms), kAcross + 1, kAcross + 1, kDiameter / kAcross, {.seed = seed});
    HeightMap map = map_of(error);
    map.height += rough.height;
    return map;
  }
};

TEST_WITH_SHORT_FORM(MapLight, TermsWithThePsdOfTheResidualHaveTheLightOfTheMap) {
  const int draws = whole ? 2 : 1;
  constexpr double kRms = 22e-9;  // g = 0.44; a sixth of the energy scatters
  const LowOrder error{12e-9, 15e-9, -10e-9};
  const Task task = scene();
  const RadialPsd psd = RoughPart::psd(kRms);
  const GeneralisedHarveyShack mean(psd, task.mirror, task.aperture, task.wavelength);
  const double g2 = std::pow(4 * kPi * kRms / kWavelength, 2);
  double worst = 0, bare = 0;
  for (int seed = 1; seed <= draws; ++seed) {
    const Lit lit = light_of(RoughPart::map(kRms, std::uint64_t(seed), error), 4);
    const MapLight& light = lit.light;
    // The RMS of the PSD has the precision of some thousand independent points.
    EXPECT_NEAR(light.rest.rms_height / kRms, 1, 0.05);
    EXPECT_NEAR(light.rest.tis, 1 - std::exp(-g2), 0.1 * g2);
    EXPECT_EQ(count_of(light.warnings, "residual-psd-rms"), 0);
    // Core and scatter: the Strehl ratio of the terms alone is larger by exp(g^2).
    const double own = std::pow(4 * kPi * lit.panels.residual.rms / kWavelength, 2);
    EXPECT_NEAR(light.terms.strehl / light.measured.strehl, std::exp(own), 0.02);
    EXPECT_NEAR(light.terms.strehl / light.terms_and_rest.strehl, std::exp(own), 0.02);
    std::vector<FocalDisc> discs;
    std::vector<Eigen::Index> at;
    for (const Eigen::Index k : {40, 80, 120, 180, 240}) {
      discs.push_back({light.radius[k], 0});
      at.push_back(k);
    }
    const Eigen::ArrayXd spread =
        RealisationSpread({psd, task.mirror, task.aperture, task.wavelength, mean}, discs).light(psd.f_min());
    for (std::size_t k = 0; k < at.size(); ++k) {
      // The PSD is known to some percent of the energy that it scatters.
      const double allowed = spread[Eigen::Index(k)] + 0.02 * g2;
      const double measured = light.measured.share[at[k]];
      worst = std::max(worst, std::abs(light.terms_and_rest.share[at[k]] - measured) / allowed);
      bare = std::max(bare, std::abs(light.terms.share[at[k]] - measured) / allowed);
    }
  }
  std::cout << "terms and PSD " << worst << " spreads from the map, terms alone " << bare << '\n';
  EXPECT_LT(worst, 3);
  EXPECT_GT(bare, 10);
}

// A hexagon with white noise, which the closed forms do not cover.
TEST(MapLight, StandsOnAnyAperture) {
  Task task = scene();
  PolygonAperture hexagon;
  for (int k = 0; k < 6; ++k)
    hexagon.vertices.push_back({kRadius * std::cos(kPi / 3 * k), kRadius * std::sin(kPi / 3 * k)});
  task.aperture = hexagon;
  const RandomStream stream(1, "map-light-hexagon");
  HeightMap map = map_of(LowOrder{12e-9, 15e-9, 0});
  for (Eigen::Index at = 0; at < map.height.size(); ++at)
    map.height.data()[at] += 15e-9 * stream.normal(std::uint64_t(at));
  const MapLight light = light_of(map, 4, task).light;
  EXPECT_NEAR(light.terms_and_rest.strehl / light.measured.strehl, 1, 0.01);
  EXPECT_NEAR(light.terms.strehl / light.measured.strehl,
              std::exp(std::pow(4 * kPi * 15e-9 / kWavelength, 2)), 0.01);
  EXPECT_NEAR(light.terms_and_rest.ee80 / light.measured.ee80, 1, 0.02);
  EXPECT_GT(light.measured.ee80 / light.terms.ee80, 1.1);
}

// White noise has a fifth of its variance in the corners of the grid's square of frequencies, beyond Nyquist.
TEST(MapLight, PsdOfTheResidualHoldsTheCornersOfTheGrid) {
  const RandomStream stream(1, "map-light-white");
  const LowOrder error{12e-9, 0, 0};
  HeightMap map = map_of(error);
  for (Eigen::Index at = 0; at < map.height.size(); ++at)
    map.height.data()[at] += 10e-9 * stream.normal(std::uint64_t(at));
  const Lit lit = light_of(map, 4);
  // 10,000 points of the rectangle determine an RMS to 0.7 %; without the corners it would be 0.89.
  EXPECT_NEAR(lit.light.rest.rms_height / lit.panels.residual.rms, 1, 0.03);
  EXPECT_NEAR(lit.light.rest.f_max, 2 / std::sqrt(kPi) * 0.5 / map.pitch_x, 1);
  EXPECT_NEAR(lit.light.terms_and_rest.strehl / lit.light.measured.strehl, 1, 5e-3);
}

// Turning marks scatter like everything else in the residual.
TEST(MapLight, PsdOfTheResidualKeepsItsLines) {
  HeightMap map = RoughPart::map(2e-9, 1, {12e-9, 0, 0});
  for (Eigen::Index row = 0; row < map.rows(); ++row)
    for (Eigen::Index column = 0; column < map.columns(); ++column)
      map.height(row, column) += 20e-9 * std::sin(2 * kPi * 600 * map.x(column));
  const Lit lit = light_of(map, 4);
  EXPECT_GT(lit.panels.residual.rms, 13e-9);
  EXPECT_NEAR(lit.light.rest.rms_height / lit.panels.residual.rms, 1, 0.1);
}

TEST(MapLight, SaysWhereOnePsdDoesNotDescribeTheResidual) {
  const LowOrder error{12e-9, 0, 0};
  const HeightMap even = RoughPart::map(22e-9, 1, error);
  HeightMap rim = RoughPart::map(2e-9, 1, error);
  const HeightMap rough = RoughPart::map(50e-9, 2, {0, 0, 0});
  for (Eigen::Index row = 0; row < rim.rows(); ++row)
    for (Eigen::Index column = 0; column < rim.columns(); ++column)
      if (std::hypot(rim.x(column), rim.y(row)) > 0.85 * kRadius)
        rim.height(row, column) += rough.height(row, column);
  EXPECT_EQ(count_of(light_of(even, 4).light.warnings, "residual-psd-rms"), 0);
  EXPECT_EQ(count_of(light_of(rim, 4).light.warnings, "residual-psd-rms"), 1);
  // The residual is equally uneven, but its scatter is too weak to matter.
  rim.height *= 0.05;
  const MapLight faint = light_of(rim, 4).light;
  EXPECT_LT(faint.rest.tis, 1e-3);
  EXPECT_EQ(count_of(faint.warnings, "residual-psd-rms"), 0);
}

TEST(MapLight, HasNoLightWhereThePhaseTurnsFasterThanThePoints) {
  // 2 um over the last tenth change the phase by more than a wave per point.
  const auto steep = [](double x, double y) { return 200e-6 * std::pow(std::hypot(x, y) / kRadius, 4); };
  const Lit lit = light_of(map_of(steep), 4);
  EXPECT_NE(lit.light.measured.obstacle.find("too steep"), std::string::npos);
  EXPECT_TRUE(std::isnan(lit.light.measured.strehl) && std::isnan(lit.light.measured.ee90));
  EXPECT_TRUE(lit.light.perfect.obstacle.empty());
  EXPECT_NEAR(lit.light.perfect.strehl, 1, 1e-12);
}

TEST(MapLight, NeedsSquareCellsForImagesOnly) {
  const LowOrder error{20e-9, 0, 0};
  HeightMap map = map_of(error);
  map.pitch_y *= 2;
  map.y0 *= 2;
  for (Eigen::Index row = 0; row < map.rows(); ++row)
    for (Eigen::Index column = 0; column < map.columns(); ++column)
      map.height(row, column) =
          std::hypot(map.x(column), map.y(row)) <= kRadius ? error(map.x(column), map.y(row)) : kNaN;
  const MapLight flat = light_of(map, 4).light, square = light_of(map_of(error), 4).light;
  EXPECT_NEAR(flat.measured.strehl / square.measured.strehl, 1, 1e-3);
  EXPECT_EQ(flat.measured.psf.intensity.size(), 0);
  EXPECT_NEAR(flat.measured.ee80 / square.measured.ee80, 1, 1e-3);
}

// A sphere at f/20 departs from a parabola by 4.8 um at the rim. All surfaces have its spherical aberration.
TEST(MapLight, StandsOnTheMirrorOfTheTask) {
  Task sphere = scene();
  sphere.mirror.conic = 0;
  const LowOrder error{20e-9, 0, 0};
  const MapLight light = light_of(map_of(error), 4, sphere).light;
  const auto departure = [](double x, double y) {  // R - sqrt(R^2 - r^2) - r^2/2R, R = 2f
    const double curvature = 2 * kFocalLength, r2 = x * x + y * y;
    return curvature - std::sqrt(curvature * curvature - r2) - r2 / (2 * curvature);
  };
  const DirectSum perfect(departure);
  const DirectSum rough([&](double x, double y) { return departure(x, y) + error(x, y); });
  EXPECT_NEAR(light.perfect.strehl, perfect.highest(), 2e-3);
  EXPECT_NEAR(light.measured.strehl, rough.highest(), 2e-3);
  EXPECT_NEAR(rough.share(light.measured.ee80), 0.8, kGridError);
  EXPECT_LT(light.perfect.strehl, 0.999);
}

}  // namespace
}  // namespace aberfit
