#include "aberfit/waves/diffraction_psf.h"

#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "aberfit/core/errors.h"
#include "aberfit/core/quadrature.h"
#include "theory/lommel.h"

namespace aberfit {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFocal = 2.8, kDiameter = 0.4, kWave = 632.8e-9;
constexpr double kAiryUnit = kWave * kFocal / kDiameter;  // lambda F

double bessel(int n, double x) { return boost::math::cyl_bessel_j(n, x); }

Eigen::VectorXd values_of(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                          const std::vector<Statistic>& statistics, int threads = 1) {
  Eigen::VectorXd values;
  evaluate_diffraction(problem, height, statistics, threads, nullptr, &values, nullptr);
  return values;
}

Eigen::ArrayXd flat(const DiffractionPupil& pupil) { return Eigen::ArrayXd::Zero(pupil.cover.size()); }

// Encircled energy of the Airy pattern of an annulus with linear obscuration e, v = pi r/(lambda F): 1/(2
// (1-e^2)) int_0^v (2 J1(t)/t - e^2 2 J1(e t)/(e t))^2 t dt (Born & Wolf 8.5; 1 - J0^2 - J1^2 for e = 0).
double airy_energy(double v, double e) {
  if (e == 0) return 1 - bessel(0, v) * bessel(0, v) - bessel(1, v) * bessel(1, v);
  const Quadrature rule = gauss_legendre(120, 0.0, v);
  double sum = 0;
  for (int k = 0; k < 120; ++k) {
    const double t = rule.nodes[k];
    const double u = 2 * bessel(1, t) / t - e * 2 * bessel(1, e * t) / t;
    sum += rule.weights[k] * u * u * t;
  }
  return sum / (2 * (1 - e * e));
}

double airy_radius(double fraction, double e) {
  double low = 0, high = 20;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (airy_energy(middle, e) < fraction ? low : high) = middle;
  }
  return low / kPi * kAiryUnit;
}

TEST(DiffractionPsf, AiryRadiiOfACircleMeetTheClosedForm) {
  // Largest errors: 2.3e-7 (EE90) for 128 cells, 1.4e-5 for 32, for even and odd grids alike.
  for (const auto& [cells, tolerance] :
       std::vector<std::pair<int, double>>{{31, 2e-5}, {32, 2e-5}, {127, 4e-7}, {128, 4e-7}}) {
    const DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / cells);
    const DiffractionProblem problem{pupil, kFocal, kWave};
    const auto found =
        values_of(problem, flat(pupil),
                  {EncircledEnergyRadius{0.5}, EncircledEnergyRadius{0.8}, EncircledEnergyRadius{0.9}});
    EXPECT_NEAR(found[0] / airy_radius(0.5, 0), 1, tolerance) << cells;
    EXPECT_NEAR(found[1] / airy_radius(0.8, 0), 1, tolerance) << cells;
    EXPECT_NEAR(found[2] / airy_radius(0.9, 0), 1, tolerance) << cells;
  }
}

TEST(DiffractionPsf, AiryEnergyOfAnAnnulusMeetsTheIntegral) {
  const double e = 0.3;
  const DiffractionPupil pupil =
      diffraction_pupil(AnnulusAperture{kDiameter, e * kDiameter}, kParaxial, kDiameter / 100);
  const DiffractionProblem problem{pupil, kFocal, kWave};
  const Eigen::ArrayXd radius = kAiryUnit * Eigen::ArrayXd::LinSpaced(6, 0.5, 3.0);
  const Eigen::ArrayXd energy = diffraction_encircled_energy(problem, flat(pupil), 0, radius);
  for (int k = 0; k < 6; ++k)
    EXPECT_NEAR(energy[k], airy_energy(kPi * radius[k] / kAiryUnit, e), 1e-6) << k;  // largest error 2e-7
}

TEST(DiffractionPsf, CoverIsTheExactAreaOfEveryAperture) {
  const std::vector<Aperture> apertures = {
      CircleAperture{0.4}, AnnulusAperture{0.4, 0.13}, RectangleAperture{0.31, 0.17},
      PolygonAperture{{{{-0.1, -0.1}, {0.2, -0.1}, {0.2, 0.15}, {0.05, 0.0}, {-0.1, 0.15}}}}};
  for (const Aperture& aperture : apertures) {
    const double pitch = 0.0137;
    const DiffractionPupil pupil = diffraction_pupil(aperture, kParaxial, pitch);
    EXPECT_NEAR(pupil.cover.sum() * pitch * pitch / aperture_area(aperture), 1, 1e-13);
    EXPECT_NEAR(pupil.amplitude.sum() / pupil.cover.sum(), 1, 1e-13);
  }
}

TEST(DiffractionPsf, EdgesIntegrateSmoothFieldsToThirdOrder) {
  // int cos(k x) cos(l y) over rectangle and triangle, against closed forms. When the pitch halves, the error
  // of the sum of `amplitude` falls by a factor of 6 or more, that of `cover` by about 4.
  const double k = 31, l = 23;
  const auto error = [&](const Aperture& aperture, double pitch, double exact, bool corrected) {
    const DiffractionPupil pupil = diffraction_pupil(aperture, kParaxial, pitch);
    const Eigen::ArrayXd field = (k * pupil.sample.x).cos() * (l * pupil.sample.y).cos();
    const double sum = ((corrected ? pupil.amplitude : pupil.cover) * field).sum() * pitch * pitch;
    return std::abs(sum - exact) / aperture_area(aperture);
  };
  const double a = 0.15, b = 0.1;
  const double rectangle = 2 * std::sin(k * a) / k * 2 * std::sin(l * b) / l;
  const Aperture box = RectangleAperture{2 * a, 2 * b};
  // Triangle (0,0), (a,0), (0,b'): int_0^a cos(kx) sin(l b(1 - x/a))/l dx, by Gauss.
  const Aperture triangle = PolygonAperture{{{{0, 0}, {a, 0}, {0, b}}}};
  const Quadrature rule = gauss_legendre(40, 0.0, a);
  const double corner =
      (rule.weights * (k * rule.nodes).cos() * (l * b * (1 - rule.nodes / a)).sin() / l).sum();
  for (const auto& [aperture, exact] : {std::pair(box, rectangle), std::pair(triangle, corner)}) {
    double coarse = 0, fine = 0, plain = 0;  // over grids that intersect the edges differently
    for (int i = 0; i < 7; ++i) {
      coarse = std::max(coarse, error(aperture, 0.0102 + 0.0003 * i, exact, true));
      fine = std::max(fine, error(aperture, (0.0102 + 0.0003 * i) / 2, exact, true));
      plain = std::max(plain, error(aperture, (0.0102 + 0.0003 * i) / 2, exact, false));
    }
    EXPECT_LT(fine, coarse / 5);
    EXPECT_LT(fine, plain / 5);
  }
}

TEST(DiffractionPsf, DefocusAgreesInSignAndSizeWithRays) {
  // A surface h = c rho^2 moves the focus: rays X = x (-4 c (f+dz) - dz/f) meet at dz = -4 c f^2/(1 + 4 c f).
  // The PSF there is the Airy pattern, larger by (f + dz)/f.
  const DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / 64);
  const DiffractionProblem problem{pupil, kFocal, kWave};
  const double c = 2e-5, dz = -4 * c * kFocal * kFocal / (1 + 4 * c * kFocal);
  const Eigen::ArrayXd height = c * (pupil.sample.x.square() + pupil.sample.y.square());
  const auto found =
      values_of(problem, height, {EncircledEnergyRadius{0.8, dz}, EncircledEnergyRadius{0.8, 0}});
  const auto plain = values_of(problem, flat(pupil), {EncircledEnergyRadius{0.8, 0}});
  EXPECT_NEAR(found[0] / (plain[0] * (kFocal + dz) / kFocal), 1, 1e-12);
  EXPECT_GT(found[1], 3 * plain[0]);
}

TEST(DiffractionPsf, EnergyBeyondTheFieldOfViewFallsWithTheCells) {
  // Airy: 1 - EE(r) -> 2 lambda F/(pi^2 r). Beyond a square of half width w it is 1.80/(pi^2 w) lambda F,
  // because the mean of 1/r over the square's edge is 0.9003/w. With w = N lambda F/2 this is 0.365/N. The
  // corrected amplitudes reduce the outermost energy slightly.
  for (const int cells : {64, 256}) {
    const DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / cells);
    const DiffractionCheck check = check_diffraction({pupil, kFocal, kWave}, flat(pupil), 0);
    EXPECT_NEAR(check.energy_outside * cells, 0.365, 0.1) << cells;
    EXPECT_NEAR(check.field_of_view / (cells * kAiryUnit), 1, 1e-12);
    EXPECT_EQ(check.aliased_share, 0);
    EXPECT_TRUE(check.warnings.empty());
  }
}

TEST(DiffractionPsf, SurfacesTooSteepForTheGridAreRefused) {
  const DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / 64);
  const DiffractionProblem problem{pupil, kFocal, kWave};
  // 4 pi slope pitch/lambda = pi when slope = lambda/(4 pitch).
  const double limit = kWave / (4 * pupil.pitch_x);
  const std::vector<Statistic> statistics = {RingThrough{5e-6, 0}};
  Eigen::VectorXd values;
  EXPECT_TRUE(
      evaluate_diffraction(problem, 0.98 * limit * pupil.sample.x, statistics, 1, nullptr, &values, nullptr));
  EXPECT_FALSE(
      evaluate_diffraction(problem, 1.02 * limit * pupil.sample.x, statistics, 1, nullptr, &values, nullptr));
  EXPECT_TRUE(std::isnan(values[0]));
  EXPECT_EQ(check_diffraction(problem, 1.02 * limit * pupil.sample.x, 0).warnings.at(0).code, "psf-aliased");
  // Defocus also steepens the phase: rays of the rim land at R dz/f.
  const double edge = 32 * kAiryUnit * kFocal / (0.5 * kDiameter);
  EXPECT_FALSE(evaluate_diffraction(problem, flat(pupil), {RingThrough{5e-6, 1.3 * edge}}, 1, nullptr,
                                    &values, nullptr));
}

TEST(DiffractionPsf, RecommendedSamplingKeepsTheSpotInHalfTheFieldOfView) {
  const double radius = 350e-6, dz = 3e-3;
  const DiffractionSampling sampling =
      diffraction_sampling(CircleAperture{kDiameter}, kFocal, kWave, radius, dz);
  const double reach = radius + 0.5 * kDiameter * dz / kFocal;
  const double half_field = 0.5 * kWave * (kFocal + dz) / sampling.pitch;
  EXPECT_GE(half_field, 2 * reach);
  EXPECT_LE(half_field, 2.02 * reach);
  EXPECT_EQ(diffraction_sampling(CircleAperture{kDiameter}, kFocal, kWave, 1e-6, 0).samples, 64);
}

TEST(DiffractionPsf, AMapWithHolesDiffractsLikeTheOpaqueAperture) {
  // A map has an unmeasured square in its centre, aligned with cells. Brute force uses the difference of two
  // rectangles: |E_outer - E_hole|^2 of both sinc products, integrated over the disc.
  HeightMap map;
  map.pitch_x = 2e-3;
  map.pitch_y = 3e-3;
  map.height = Grid::Zero(50, 60);
  map.x0 = -29.5 * map.pitch_x;
  map.y0 = -24.5 * map.pitch_y;
  for (int row = 20; row < 30; ++row)
    for (int column = 20; column < 40; ++column) map.height(row, column) = std::nan("");
  const double wx = 60 * map.pitch_x, wy = 50 * map.pitch_y, hx = 20 * map.pitch_x, hy = 10 * map.pitch_y;
  Eigen::ArrayXd height;
  const DiffractionPupil pupil = diffraction_pupil(map, RectangleAperture{wx, wy}, &height);
  EXPECT_EQ(height.size(), 3000 - 200);
  EXPECT_NEAR(pupil.missing, 200.0 / 3000, 1e-12);
  const DiffractionProblem problem{pupil, kFocal, kWave};
  const double waves = kWave * kFocal;
  const auto sinc = [](double t) { return t == 0 ? 1.0 : std::sin(kPi * t) / (kPi * t); };
  const auto intensity = [&](double x, double y) {
    const double u = wx * wy * sinc(wx * x / waves) * sinc(wy * y / waves) -
                     hx * hy * sinc(hx * x / waves) * sinc(hy * y / waves);
    return u * u / (waves * waves * (wx * wy - hx * hy));
  };
  for (const double radius : {8e-6, 20e-6, 40e-6}) {
    const Quadrature rule = gauss_legendre(60, 0.0, radius);
    double energy = 0;
    for (int k = 0; k < 60; ++k)
      for (int j = 0; j < 128; ++j)
        energy += rule.weights[k] * rule.nodes[k] * 2 * kPi / 128 *
                  intensity(rule.nodes[k] * std::cos(2 * kPi * j / 128),
                            rule.nodes[k] * std::sin(2 * kPi * j / 128));
    const double found =
        diffraction_encircled_energy(problem, height, 0, Eigen::ArrayXd::Constant(1, radius))[0];
    EXPECT_NEAR(found, energy, 5e-5) << radius;  // third-order edges; largest error 2e-5
  }
  EXPECT_EQ(check_diffraction(problem, height, 0).warnings.at(0).code, "psf-holes");
}

TEST(DiffractionPsf, StatisticsWithoutAFiniteValueAreRefused) {
  const DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / 32);
  const DiffractionProblem problem{pupil, kFocal, kWave};
  for (const Statistic& statistic :
       std::vector<Statistic>{ScatterRms{}, ScatterMean{}, RmsRadius{0}, RmsHeight{},
                              EncircledEnergyRadius{0.999, 0}, RingThrough{1, 0}}) {
    Eigen::VectorXd values;
    EXPECT_FALSE(evaluate_diffraction(problem, flat(pupil), {statistic}, 1, nullptr, &values, nullptr));
    EXPECT_TRUE(std::isnan(values[0])) << statistic_name(statistic);
  }
  EXPECT_THROW(diffraction_pupil(CircleAperture{kDiameter}, kParaxial, 1e-6), ComputationError);
}

TEST(DiffractionPsf, PlanesThatDoNotExistHaveNoValues) {
  const DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / 16);
  const DiffractionProblem problem{pupil, kFocal, kWave};
  const Eigen::ArrayXd radius = Eigen::ArrayXd::Constant(2, kAiryUnit);
  const double infinity = std::numeric_limits<double>::infinity();
  const Eigen::VectorXd in_focus = values_of(problem, flat(pupil), {EncircledEnergyRadius{0.5, 0}});
  for (const double dz : {-kFocal, -1.5 * kFocal, infinity, -infinity, std::nan("")}) {
    EXPECT_THROW(check_diffraction(problem, flat(pupil), dz), std::invalid_argument) << dz;
    EXPECT_TRUE(diffraction_encircled_energy(problem, flat(pupil), dz, radius).isNaN().all()) << dz;
    EXPECT_THROW(diffraction_psf(problem, flat(pupil), {0, 0, dz}), ComputationError) << dz;
    // They do not disturb neighbouring planes either.
    const Eigen::VectorXd found = values_of(problem, flat(pupil),
                                            {EncircledEnergyRadius{0.5, dz}, EncircledEnergyRadius{0.5, 0},
                                             RingThrough{kAiryUnit, dz}, EncircledEnergyRadius{0.5, 0}});
    EXPECT_TRUE(std::isnan(found[0]) && std::isnan(found[2])) << dz;
    EXPECT_EQ(found[1], in_focus[0]) << dz;
    EXPECT_EQ(found[3], in_focus[0]) << dz;
  }
  EXPECT_NO_THROW(check_diffraction(problem, flat(pupil), -0.99 * kFocal));
  EXPECT_FALSE(diffraction_encircled_energy(problem, flat(pupil), 0, radius).isNaN().any());
}

TEST(DiffractionPsf, HeightsThatAreNotFiniteAreRefused) {
  const DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / 16);
  const DiffractionProblem problem{pupil, kFocal, kWave};
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    Eigen::ArrayXd height = flat(pupil);
    height[height.size() / 2] = bad;
    const Eigen::ArrayXd radius = Eigen::ArrayXd::Constant(1, kAiryUnit);
    EXPECT_THROW(diffraction_encircled_energy(problem, height, 0, radius), std::invalid_argument);
    EXPECT_THROW(diffraction_psf(problem, height, {}), std::invalid_argument);
    EXPECT_TRUE(std::isnan(values_of(problem, height, {EncircledEnergyRadius{0.5}})[0]));
    const DiffractionCheck check = check_diffraction(problem, height, 0);
    EXPECT_TRUE(std::isnan(check.largest_step) && std::isnan(check.aliased_share));
    EXPECT_EQ(check.field_of_view, check_diffraction(problem, flat(pupil), 0).field_of_view);
    ASSERT_EQ(check.warnings.size(), 1u);
    EXPECT_EQ(check.warnings[0].code, "psf-not-finite");
  }
}

TEST(DiffractionPsf, RingThroughProfileOfAnIdealMirrorPeaksAtFocusAndHasTheRightWidth) {
  const DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / 128);
  const DiffractionProblem problem{pupil, kFocal, kWave};
  const double ring = airy_radius(0.9, 0);
  const auto found = values_of(problem, flat(pupil), {RingFwhm{0.9, std::nullopt}, RingFwhm{0.9, ring}});
  EXPECT_NEAR(found[0] / found[1], 1, 1e-6);
  // Second method: N(z) by Lommel's integral.
  const auto share = [&](double dz) {
    return test::light_by_lommel(0.5 * kDiameter, kFocal, kWave, ring, dz);
  };
  double peak = 0;
  for (int k = -100; k <= 100; ++k) peak = std::max(peak, share(k * 1e-6));
  const auto crossing = [&](double outside) {
    double inside = 0;
    for (int k = 0; k < 50; ++k) {
      const double middle = 0.5 * (inside + outside);
      (share(middle) > 0.5 * peak ? inside : outside) = middle;
    }
    return inside;
  };
  EXPECT_NEAR(found[1] / (crossing(5e-4) - crossing(-5e-4)), 1, 2e-6);
}

TEST(DiffractionPsf, LineSpreadWidthOfASquareIsThatOfSincSquared) {
  // L(x) ~ sinc^2(w x/(lambda f)) along the side of a square, with FWHM 0.885892941 lambda f/w.
  const DiffractionPupil pupil = diffraction_pupil(RectangleAperture{0.3, 0.3}, kParaxial, 0.3 / 100);
  const auto found = values_of({pupil, kFocal, kWave}, flat(pupil), {SpotFwhm{0}});
  EXPECT_NEAR(found[0] / (0.885892941 * kWave * kFocal / 0.3), 1, 1e-5);
}

TEST(DiffractionPsf, ResultsDoNotDependOnThreadsOrOnReusedMemory) {
  const DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / 40);
  const Eigen::ArrayXd height = 60e-9 * (25 * pupil.sample.x + 3).sin() * (31 * pupil.sample.y).cos();
  const DiffractionProblem problem{pupil, kFocal, kWave};
  const std::vector<Statistic> statistics = {EncircledEnergyRadius{0.5, 0}, RingFwhm{},
                                             EncircledEnergyRadius{0.9, 2e-4}, EncircledEnergyRadius{0.3, 0},
                                             SpotFwhm{1e-6}};
  Eigen::VectorXd one, three;
  std::vector<Eigen::ArrayXd> d_one, d_three;
  DiffractionWorkspace workspace;
  ASSERT_TRUE(evaluate_diffraction(problem, height, statistics, 1, nullptr, &one, &d_one));
  for (int round = 0; round < 2; ++round) {
    ASSERT_TRUE(evaluate_diffraction(problem, height, statistics, 3, &workspace, &three, &d_three));
    EXPECT_EQ(one, three);
    for (std::size_t k = 0; k < statistics.size(); ++k) EXPECT_TRUE((d_one[k] == d_three[k]).all()) << k;
  }
}

TEST(DiffractionPsf, AWorkspaceTellsOneSurfaceFromTheNext) {
  // Stored data of a plane must depend on the heights, the pupil, the wavelength and the mirror.
  const std::vector<Statistic> statistics = {EncircledEnergyRadius{0.5, 0}, RingFwhm{},
                                             EncircledEnergyRadius{0.9, 2e-4}, RingThrough{6e-6, 2e-4},
                                             SpotFwhm{1e-6}};
  const std::vector<Statistic> other_planes = {EncircledEnergyRadius{0.6, -1e-4},
                                               EncircledEnergyRadius{0.6, 2e-4}};
  DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / 40);
  Eigen::ArrayXd height = 60e-9 * (25 * pupil.sample.x + 3).sin() * (31 * pupil.sample.y).cos();
  DiffractionWorkspace workspace;
  const auto compare = [&](const DiffractionProblem& problem, const std::vector<Statistic>& wanted) {
    Eigen::VectorXd fresh, kept, kept_too;
    std::vector<Eigen::ArrayXd> d_fresh, d_kept;
    ASSERT_TRUE(evaluate_diffraction(problem, height, wanted, 1, nullptr, &fresh, &d_fresh));
    ASSERT_TRUE(evaluate_diffraction(problem, height, wanted, 1, &workspace, &kept, nullptr));
    ASSERT_TRUE(evaluate_diffraction(problem, height, wanted, 1, &workspace, &kept_too, &d_kept));
    EXPECT_EQ(fresh, kept);
    EXPECT_EQ(fresh, kept_too);
    for (std::size_t k = 0; k < wanted.size(); ++k) EXPECT_TRUE((d_fresh[k] == d_kept[k]).all()) << k;
  };
  compare({pupil, kFocal, kWave}, statistics);
  compare({pupil, kFocal, kWave}, other_planes);
  height *= 1 + 1e-15;
  compare({pupil, kFocal, kWave}, statistics);
  compare({pupil, kFocal, 1.01 * kWave}, statistics);
  compare({pupil, 1.01 * kFocal, kWave}, statistics);
  compare({pupil, kFocal, kWave, 3}, statistics);
  pupil.amplitude[100] *= 0.5;  // in place, so the address is the same
  compare({pupil, kFocal, kWave}, statistics);
  pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / 36);
  height = 60e-9 * (25 * pupil.sample.x + 3).sin();
  compare({pupil, kFocal, kWave}, statistics);
}

// A followed ring must be the one that a search finds. The surfaces and grids differ slightly or strongly,
// and some starting values are useless.
TEST(DiffractionPsf, RingsThatAreFollowedAreThoseThatAreFound) {
  const std::vector<Statistic> rings = {RingFwhm{}, RingFwhm{0.5, std::nullopt}, RingFwhm{0.8, std::nullopt}};
  DiffractionWorkspace workspace;
  workspace.follow_rings();
  constexpr double kFollowed = 1e-6;  // 1e-6 of a step of the search on either side
  for (const int cells : {40, 54})
    for (const double rms : {60e-9, 61e-9, 30e-9, 120e-9, 0.0}) {
      const DiffractionPupil pupil =
          diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / cells);
      const Eigen::ArrayXd height = rms * (25 * pupil.sample.x + 3).sin() * (31 * pupil.sample.y).cos();
      Eigen::VectorXd searched, followed;
      evaluate_diffraction({pupil, kFocal, kWave}, height, rings, 1, nullptr, &searched, nullptr);
      evaluate_diffraction({pupil, kFocal, kWave}, height, rings, 2, &workspace, &followed, nullptr);
      for (Eigen::Index k = 0; k < searched.size(); ++k)
        EXPECT_NEAR(followed[k] / searched[k], 1, kFollowed) << cells << ' ' << rms << ' ' << k;
    }
}

}  // namespace
}  // namespace aberfit
