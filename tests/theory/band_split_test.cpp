#include "aberfit/theory/band_split.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"
#include "aberfit/roughness/random_surface.h"
#include "aberfit/scene/segments.h"
#include "aberfit/theory/geometric_harvey_shack.h"
#include "height_between.h"

// Roughness in two parts: a surface below a frequency, and its mean on the transfer function above it.

namespace aberfit {
namespace {

constexpr double kWave = 632.8e-9, kRadius = 0.1;

struct Scene {
  RadialPsd psd;
  Aperture aperture;
  Mirror mirror;
};

double height_of(double g) { return g * kWave / (4 * std::numbers::pi); }

// 24 cycles across.
Scene scene_of(int family, bool annulus, double g) {
  const double rms = height_of(g), f_min = 10, f_max = 120;
  const std::array<PsdModel, 3> models{KCorrelationPsd{rms, 0.04, 3.0, f_min, f_max},
                                       PowerLawPsd{rms, {}, 2.2, f_min, f_max},
                                       UniformPsd{rms, f_min, f_max}};
  Aperture aperture = CircleAperture{2 * kRadius};
  if (annulus) aperture = AnnulusAperture{2 * kRadius, 0.7 * kRadius};
  Mirror mirror;
  mirror.focal_length = 1.6;  // f/8
  return {RadialPsd(models[std::size_t(family)]), aperture, mirror};
}

std::shared_ptr<const GeneralisedHarveyShack> whole_of(const Scene& scene) {
  return std::make_shared<const GeneralisedHarveyShack>(scene.psd, scene.mirror, scene.aperture, kWave);
}

std::shared_ptr<const BandSplit> split_at(const Scene& scene, double cut) {
  return std::make_shared<const BandSplit>(scene.psd, cut, scene.mirror, scene.aperture, kWave,
                                           whole_of(scene));
}

double depth_of_focus(const Scene& scene) {
  return kWave * std::pow(scene.mirror.focal_length / (2 * kRadius), 2);
}

// Radii of the mean spot in focus, one wave from it on either side, and three waves from it.
std::vector<Statistic> shares_of(const Scene& scene, const GeneralisedHarveyShack& whole) {
  std::vector<Statistic> shares;
  for (const double waves : {0.0, 1.0, -1.0, 3.0}) {
    const double dz = 8 * waves * depth_of_focus(scene);
    const MeanSpot spot = whole.at_plane(dz);
    for (const double p : {0.2, 0.5, 0.8, 0.95})
      shares.push_back(RingThrough{spot.encircled_energy_radius(p), dz});
  }
  return shares;
}

Eigen::ArrayXd heights_at(const HeightMap& map, double pitch, const PupilSample& sample) {
  Eigen::ArrayXd height(sample.size());
  for (Eigen::Index k = 0; k < height.size(); ++k)
    height[k] = test::height_between(map, pitch, sample.x[k], sample.y[k]);
  return height;
}

// Random errors of all segments: a piston, and slopes times the distance from the middle.
Eigen::ArrayXd drawn_errors(const Scene& scene, const PupilSample& sample, std::uint64_t seed) {
  const Segments segments(std::get<SegmentedAperture>(scene.aperture));
  const RandomStream random(seed, "segments");
  Eigen::ArrayXd height(sample.size());
  for (Eigen::Index k = 0; k < height.size(); ++k) {
    const std::uint64_t number = sample.segment[std::size_t(k)];
    const auto [piston, unused] = random.normal_pair(2 * number);
    const auto [along_x, along_y] = random.normal_pair(2 * number + 1);
    const auto& centre = segments.all()[number].centre;
    height[k] = segments.piston() * piston + segments.tip_tilt() * (along_x * (sample.x[k] - centre[0]) +
                                                                    along_y * (sample.y[k] - centre[1]));
  }
  return height;
}

// Encircled energies of `draws` realisations with `psd`, one column each.
Eigen::MatrixXd shares_of_draws(const Scene& scene, const RadialPsd& psd,
                                const std::shared_ptr<const MeanScatter>& scatter,
                                const std::vector<Statistic>& shares, int draws, std::uint64_t seed,
                                int cells = 128) {
  constexpr int kMap = 640;
  const double pitch = 2.1 * kRadius / kMap;
  const DiffractionPupil pupil =
      diffraction_pupil(scene.aperture, scene.mirror.focal_length, 2 * kRadius / cells);
  Eigen::MatrixXd values(Eigen::Index(shares.size()), draws);
  parallel_for(std::size_t(draws), available_threads(), [&](std::size_t i) {
    RandomSurfaceOptions options;
    options.seed = seed + i;
    Eigen::ArrayXd height = heights_at(random_surface(psd, kMap, kMap, pitch, options), pitch, pupil.sample);
    if (has_segment_errors(scene.aperture)) height += drawn_errors(scene, pupil.sample, options.seed);
    DiffractionProblem problem{pupil, scene.mirror.focal_length, kWave};
    problem.scatter = scatter;
    problem.aliased_limit = 0.01;
    Eigen::VectorXd value;
    EXPECT_TRUE(evaluate_diffraction(problem, height, shares, 1, nullptr, &value, nullptr));
    values.col(Eigen::Index(i)) = value;
  });
  return values;
}

void expect_mean(const Eigen::MatrixXd& values, const GeneralisedHarveyShack& whole,
                 const std::vector<Statistic>& shares, double also_allowed) {
  for (Eigen::Index k = 0; k < values.rows(); ++k) {
    const auto& ring = std::get<RingThrough>(shares[std::size_t(k)]);
    const double mean = values.row(k).mean(), n = double(values.cols());
    const double error = std::sqrt((values.row(k).array() - mean).square().sum() / (n * (n - 1)));
    EXPECT_NEAR(mean, whole.encircled_energy(ring.ring_radius, ring.dz), 4 * error + also_allowed)
        << "radius " << ring.ring_radius << " m, dz " << ring.dz << " m, standard error " << error;
  }
}

// Tests realisations of the low part with the rest as its mean, and realisations of everything.
void expect_exact_split(int family, bool annulus, double g, double cut, int draws) {
  SCOPED_TRACE(testing::Message() << "family " << family << ", annulus " << annulus << ", g " << g << ", cut "
                                  << cut << " /m");
  const Scene scene = scene_of(family, annulus, g);
  const auto whole = whole_of(scene);
  const auto split = split_at(scene, cut);
  const std::vector<Statistic> shares = shares_of(scene, *whole);
  // 1e-4 is the error of the mean factor out of focus, and of its grid.
  expect_mean(shares_of_draws(scene, split->low(), split, shares, draws, 1), *whole, shares, 1e-4);
  // Full realisations scatter beyond the field of view of their grid, which affects the 95 % radius.
  expect_mean(shares_of_draws(scene, scene.psd, nullptr, shares, draws, 5001), *whole, shares, 3e-3);
}

}  // namespace

// Energy beyond the field of view is that of the roughness alone, because the grid has the segment errors.
TEST(BandSplit, OfSegmentsThatErrHasTheirMeanLight) {
  Scene scene = scene_of(0, false, 0.6);
  SegmentedAperture segments = hexagonal_segments(1, 0.06, 0.001, true, 0);
  segments.piston = 40e-9;
  segments.tip_tilt = 1e-6;
  scene.aperture = segments;
  const auto whole = whole_of(scene);
  const auto split = split_at(scene, 40);
  const std::vector<Statistic> shares = shares_of(scene, *whole);
  expect_mean(shares_of_draws(scene, split->low(), split, shares, 80, 1), *whole, shares, 1e-4);
  Scene in_place = scene;
  in_place.aperture = without_segment_errors(scene.aperture);
  const auto other = split_at(in_place, 40);
  for (const double radius : {3e-6, 1e-5, 5e-5}) {
    EXPECT_EQ(split->encircled_energy(radius), other->encircled_energy(radius));
    EXPECT_LT(whole->encircled_energy(radius, 0), 0.99 * other->encircled_energy(radius));
  }
}

TEST(BandSplit, AtTheBottomOfTheBandIsHarveyShack) {
  for (const bool annulus : {false, true}) {
    const Scene scene = scene_of(0, annulus, 0.8);
    const auto split = split_at(scene, scene.psd.f_min());
    EXPECT_FALSE(split->has_low());
    const auto whole = whole_of(scene);
    const DiffractionPupil pupil =
        diffraction_pupil(scene.aperture, scene.mirror.focal_length, 2 * kRadius / 96);
    DiffractionProblem problem{pupil, scene.mirror.focal_length, kWave};
    problem.scatter = split;
    std::vector<Statistic> shares = shares_of(scene, *whole);
    shares.push_back(EncircledEnergyRadius{0.9, 0});
    shares.push_back(EncircledEnergyRadius{0.99, 0});  // outside the field of view
    Eigen::VectorXd value;
    ASSERT_TRUE(evaluate_diffraction(problem, Eigen::ArrayXd::Zero(pupil.sample.size()), shares, 1, nullptr,
                                     &value, nullptr));
    for (std::size_t k = 0; k < shares.size(); ++k) {
      const double truth = (*whole)(shares[k]), found = value[Eigen::Index(k)];
      const auto* ring = std::get_if<RingThrough>(&shares[k]);
      const bool in_focus = !ring || ring->dz == 0;
      EXPECT_NEAR(found / truth, 1, in_focus ? 1e-9 : 2e-4) << statistic_name(shares[k]);
    }
  }
}

// Half of the energy scattered by 24 cycles across lies beyond the 16 cycles of this grid, and three waves of
// defocus add another 12 cycles. The curve of the focus would not do.
TEST(BandSplit, InEveryPlaneTheLightBeyondTheCellsIsThatPlanes) {
  const Scene scene = scene_of(2, false, 1.5);
  const auto whole = whole_of(scene);
  const std::vector<Statistic> shares = shares_of(scene, *whole);
  constexpr int kCells = 32;
  const DiffractionPupil pupil =
      diffraction_pupil(scene.aperture, scene.mirror.focal_length, 2 * kRadius / kCells);
  DiffractionProblem problem{pupil, scene.mirror.focal_length, kWave};
  problem.scatter = split_at(scene, scene.psd.f_min());
  const Eigen::ArrayXd flat = Eigen::ArrayXd::Zero(pupil.sample.size());
  Eigen::VectorXd value;
  ASSERT_TRUE(evaluate_diffraction(problem, flat, shares, 2, nullptr, &value, nullptr));
  double worst = 0, of_focus = 0;
  for (std::size_t k = 0; k < shares.size(); ++k) {
    const auto& ring = std::get<RingThrough>(shares[k]);
    const double truth = whole->encircled_energy(ring.ring_radius, ring.dz);
    worst = std::max(worst, std::abs(value[Eigen::Index(k)] - truth));
    const double grown = scene.mirror.focal_length / (scene.mirror.focal_length + ring.dz);
    of_focus = std::max(of_focus, std::abs(whole->encircled_energy(ring.ring_radius * grown, 0) - truth));
  }
  EXPECT_LT(worst, 1e-9);
  EXPECT_GT(of_focus, 0.03);  // the curve of the focus differs
  // Surfaces with a low part that the grid resolves, and their energy in the planes.
  expect_mean(
      shares_of_draws(scene, split_at(scene, 30)->low(), split_at(scene, 30), shares, 60, 301, kCells),
      *whole, shares, 3e-4);
}

// Width of N(z), the energy inside `ring`, from a table of planes 1/50 of `about` apart. Linear interpolation
// errs by 5e-4.
double width_from_table(const DiffractionProblem& problem, const Eigen::ArrayXd& height, double ring,
                        double about) {
  constexpr int kPlanes = 40;  // on either side
  const double step = 0.02 * about;
  std::vector<Statistic> through;
  for (int k = -kPlanes; k <= kPlanes; ++k) through.push_back(RingThrough{ring, k * step});
  Eigen::VectorXd n;
  EXPECT_TRUE(evaluate_diffraction(problem, height, through, 2, nullptr, &n, nullptr));
  Eigen::Index peak = 0;
  const double half = 0.5 * n.maxCoeff(&peak);
  const auto crossing = [&](Eigen::Index by) {
    Eigen::Index k = peak;
    while (k + by > 0 && k + by < 2 * kPlanes && n[k + by] > half) k += by;
    return step * (double(k) + double(by) * (n[k] - half) / (n[k] - n[k + by]));
  };
  return crossing(1) - crossing(-1);
}

// The same for followed rings: the halo of the focus would make widths wrong by a few per cent.
TEST(BandSplit, RingsSeeTheLightBeyondTheCellsOfTheirPlanes) {
  struct Case {
    int family, cells;
    double g, fraction;
  };
  for (const Case& of : {Case{0, 40, 1.5, 0.3}, Case{1, 48, 2.0, 0.2}}) {
    SCOPED_TRACE(testing::Message() << "family " << of.family << ", g " << of.g);
    const Scene scene = scene_of(of.family, false, of.g);
    const auto split = split_at(scene, 30);
    const DiffractionPupil pupil =
        diffraction_pupil(scene.aperture, scene.mirror.focal_length, 2 * kRadius / of.cells);
    constexpr int kMap = 640;
    const double pitch = 2.1 * kRadius / kMap;
    const Eigen::ArrayXd height =
        heights_at(random_surface(split->low(), kMap, kMap, pitch, {}), pitch, pupil.sample);
    DiffractionProblem problem{pupil, scene.mirror.focal_length, kWave};
    problem.scatter = split;
    problem.aliased_limit = 0.2;  // far out of focus at the rim
    const double ring = whole_of(scene)->encircled_energy_radius(of.fraction, 0);
    const std::vector<Statistic> width = {RingFwhm{of.fraction, ring}};
    Eigen::VectorXd searched, followed;
    DiffractionWorkspace workspace;
    workspace.follow_rings();
    ASSERT_TRUE(evaluate_diffraction(problem, height, width, 2, nullptr, &searched, nullptr));
    ASSERT_TRUE(evaluate_diffraction(problem, 1.01 * height, width, 2, &workspace, &followed, nullptr));
    ASSERT_TRUE(evaluate_diffraction(problem, height, width, 2, &workspace, &followed, nullptr));
    const double truth = width_from_table(problem, height, ring, searched[0]);
    EXPECT_NEAR(searched[0] / truth, 1, 1e-3);
    EXPECT_NEAR(followed[0] / searched[0], 1, 2e-4);
    // For a ring that moves with the surface, the energy beyond the field of view changes, too.
    const std::vector<Statistic> own = {RingFwhm{of.fraction, {}}};
    std::vector<Eigen::ArrayXd> gradient;
    Eigen::VectorXd here, less, more;
    ASSERT_TRUE(evaluate_diffraction(problem, height, own, 2, nullptr, &here, &gradient));
    constexpr double kStep = 1e-4;
    ASSERT_TRUE(evaluate_diffraction(problem, (1 - kStep) * height, own, 2, nullptr, &less, nullptr));
    ASSERT_TRUE(evaluate_diffraction(problem, (1 + kStep) * height, own, 2, nullptr, &more, nullptr));
    const double slope = (more[0] - less[0]) / (2 * kStep);
    EXPECT_NEAR((gradient[0] * height).sum() / slope, 1, 1e-3);
  }
}

TEST(BandSplit, AtTheTopOfTheBandLeavesEverythingToTheSurface) {
  const Scene scene = scene_of(0, false, 0.8);
  const auto split = split_at(scene, scene.psd.f_max());
  EXPECT_FALSE(split->has_rest());
  EXPECT_EQ(split->rms_height(), 0);
  EXPECT_EQ(split->scatter_rms(), 0);
  EXPECT_EQ(split->tis(), 0);
  const Eigen::ArrayXd x = Eigen::ArrayXd::LinSpaced(50, 0, 2 * kRadius);
  EXPECT_TRUE((split->transfer(x) == 1).all());
  EXPECT_LT((split->whole_transfer(x) - whole_of(scene)->overlap_transfer(x)).abs().maxCoeff(), 1e-12);
}

TEST(BandSplit, PartsAddInSquaresAndMultiply) {
  const Scene scene = scene_of(1, false, 1.5);
  for (const double cut : {20.0, 45.0, 100.0}) {
    const auto split = split_at(scene, cut);
    const PsdMoments low = psd_moments(split->low()), all = psd_moments(scene.psd);
    EXPECT_NEAR(std::hypot(low.rms_height(), split->rms_height()) / all.rms_height(), 1, 1e-12);
    EXPECT_NEAR(std::hypot(low.rms_slope_per_axis(), split->rms_slope_per_axis()) / all.rms_slope_per_axis(),
                1, 1e-12);
    const GeometricHarveyShack low_rays(scene.mirror, scene.aperture, low.rms_slope_per_axis(),
                                        Convention::kPhysical, low.rms_height());
    EXPECT_NEAR(std::hypot(low_rays.scatter_rms(), split->scatter_rms()) / whole_of(scene)->scatter_rms(), 1,
                1e-9);
    // At f/8 the exponent varies by 2 % over the aperture. The product of means is the mean of products to
    // second order in that.
    const Eigen::ArrayXd x = Eigen::ArrayXd::LinSpaced(200, 0, 1.9 * kRadius);
    const Eigen::ArrayXd product = split->whole_transfer(x), whole = whole_of(scene)->overlap_transfer(x);
    EXPECT_LT((product - whole).abs().maxCoeff(), 2e-5);
    EXPECT_GT((split->transfer(x) - whole).abs().maxCoeff(), 0.01);
  }
}

TEST(BandSplit, MeanOfDrawsIsHarveyShack) { expect_exact_split(0, true, 1.0, 40, 48); }

TEST(FullStatistics, MeanOfSplitDrawsIsHarveyShack) {
  for (const int family : {0, 1, 2})
    for (const bool annulus : {false, true})
      for (const double cut : {20.0, 40.0, 80.0}) expect_exact_split(family, annulus, 1.0, cut, 200);
}

}  // namespace aberfit
