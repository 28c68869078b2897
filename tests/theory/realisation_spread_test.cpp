#include "aberfit/theory/realisation_spread.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/waves/diffraction_psf.h"
#include "drawn_mirrors.h"
#include "short_form.h"

using namespace aberfit;
using namespace aberfit::testing_draws;
using std::numbers::pi;

namespace {

constexpr double kLambda = 632.8e-9, kFocal = 2.8, kDiameter = 0.4;
const Mirror kParabola{kFocal, -1, {}};
const double kWave =
    kLambda * 2 * kFocal * kFocal / (0.25 * kDiameter * kDiameter);  // defocus dz of one wave
constexpr double kMargin = 0.01;                                     // PHYSICS 7
constexpr double kPromisedFactor = 1.5;                              // predicted over measured
constexpr double kFieldOfView = 0.4;     // discs in the grid, over wavelength f/pitch
constexpr double kWhereItMatters = 0.1;  // in tolerances
// Standard deviations of n realisations have the standard error 1/sqrt(2 n): three of these for 60.
constexpr double kSampling = 1.27;

double height_of(double g) { return g * kLambda / (4 * pi); }

struct Case {
  std::string name;
  PsdModel psd;
  double inner_diameter;
  Aperture aperture() const {
    if (inner_diameter > 0) return AnnulusAperture{kDiameter, inner_diameter};
    return CircleAperture{kDiameter};
  }
};

// Largest ratio of predicted and measured spread, or its inverse; in the focus and two waves from it.
double worst_factor(const Case& scene, int cells, int draws, std::uint64_t seed, double sampling) {
  const RadialPsd psd(scene.psd);
  const Aperture aperture = scene.aperture();
  const GeneralisedHarveyShack mean(psd, kParabola, aperture, kLambda);
  const std::vector<double> cuts{3 / kDiameter, 6 / kDiameter, 12 / kDiameter};
  std::vector<DrawnMirrors::Discs> planes;
  std::vector<FocalDisc> discs;
  std::vector<double> tolerance;
  for (const double dz : {0.0, 2 * kWave}) {
    const MeanSpot spot = mean.at_plane(dz);
    DrawnMirrors::Discs plane{dz, {}};
    for (const double fraction : {0.15, 0.4, 0.7, 0.9}) {
      const double r = spot.encircled_energy_radius(fraction);
      if (r > kFieldOfView * kLambda * kFocal * cells / kDiameter) continue;
      plane.radius.push_back(r);
      discs.push_back({r, dz});
      tolerance.push_back(kMargin * std::max(r * spot.encircled_energy_slope(r), 0.35));
    }
    planes.push_back(plane);
  }
  const RealisationSpread predicted({psd, kParabola, aperture, kLambda, mean}, discs);
  DrawnMirrors drawn({psd, kFocal, kDiameter, scene.inner_diameter, kLambda, cells}, cuts);
  const std::vector<Eigen::ArrayXXd> measured = drawn.spread(planes, draws, seed);
  double worst = 0;
  int looked_at = 0;
  for (std::size_t c = 0; c < cuts.size(); ++c) {
    const Eigen::ArrayXd light = predicted.light(cuts[c]);
    for (std::size_t d = 0; d < discs.size(); ++d) {
      const std::size_t first = planes[0].radius.size(), plane = d < first ? 0 : 1;
      const std::size_t disc = d - plane * first;
      const double spread = measured[plane](Eigen::Index(disc), Eigen::Index(c));
      if (!(spread > kWhereItMatters * tolerance[d])) continue;
      ++looked_at;
      const double ratio = light[Eigen::Index(d)] / spread;
      worst = std::max({worst, ratio, 1 / ratio});
      EXPECT_LT(std::max(ratio, 1 / ratio), kPromisedFactor * sampling)
          << scene.name << " cut " << cuts[c] * kDiameter << " cycles across, dz " << planes[plane].dz
          << " r " << discs[d].radius << " predicted " << light[Eigen::Index(d)] << " measured " << spread;
    }
  }
  EXPECT_GT(looked_at, 3) << scene.name;
  return worst;
}

struct LargeAnnulus {
  RadialPsd psd{KCorrelationPsd{15e-9, 0.3, 2.8, 0.8, 200}};
  Mirror mirror{5.52, -1, {}};
  Aperture aperture = AnnulusAperture{2.4, 0.8};
  double wavelength = 550e-9;
  GeneralisedHarveyShack mean{psd, mirror, aperture, wavelength};
  std::vector<FocalDisc> discs{{1e-6, 0}, {3e-6, 0}, {8e-6, 0}, {20e-6, 0}, {35e-6, 0}};
  RealisationSpread spread{{psd, mirror, aperture, wavelength, mean}, discs};
};

}  // namespace

TEST_WITH_SHORT_FORM(RealisationSpread, DrawnMirrorsDifferAsPredicted) {
  double worst = 0;
  const std::vector<Case> cases = {
      {"gaussian g 0.3", GaussianPsd{height_of(0.3), 0.03}, 0},
      {"k-correlation g 1", KCorrelationPsd{height_of(1), 0.1, 2.8, 2.5, 60}, 0.14},
      {"power law g 0.1", PowerLawPsd{height_of(0.1), {}, 2.5, 2.5, 60}, 0},
      {"uniform g 2", UniformPsd{height_of(2), 2.5, 20}, 0.14}};
  std::uint64_t seed = 31;
  for (const Case& scene : aberfit::test::all_or_few(whole, cases, {1}))
    worst = std::max(worst, worst_factor(scene, 64, 60, ++seed, kSampling));
  RecordProperty("worst_factor_in_hundredths", int(100 * worst));
}

namespace {

std::vector<Case> twelve_scenes() {
  return {{"gaussian g 0.1", GaussianPsd{height_of(0.1), 0.025}, 0},
          {"gaussian g 1", GaussianPsd{height_of(1), 0.025}, 0.14},
          {"gaussian g 2", GaussianPsd{height_of(2), 0.025}, 0},
          {"k-correlation g 0.3", KCorrelationPsd{height_of(0.3), 0.1, 2.8, 2.5, 100}, 0.14},
          {"k-correlation g 1", KCorrelationPsd{height_of(1), 0.1, 2.8, 2.5, 100}, 0},
          {"k-correlation g 5", KCorrelationPsd{height_of(5), 0.1, 4, 2.5, 100}, 0.14},
          {"power law g 0.1", PowerLawPsd{height_of(0.1), {}, 2.5, 2.5, 100}, 0},
          {"power law g 2", PowerLawPsd{height_of(2), {}, 2.5, 2.5, 100}, 0.14},
          {"power law g 5", PowerLawPsd{height_of(5), {}, 4, 2.5, 100}, 0},
          {"uniform g 0.3", UniformPsd{height_of(0.3), 2.5, 60}, 0},
          {"uniform g 2", UniformPsd{height_of(2), 2.5, 60}, 0.14},
          {"uniform g 5", UniformPsd{height_of(5), 2.5, 25}, 0}};
}

// Largest ratio of the measured spread and the limit, a third of the tolerance, at the chosen cut.
double worst_of_promise(const Case& scene, int cells, int draws, std::uint64_t seed) {
  const RadialPsd psd(scene.psd);
  const Aperture aperture = scene.aperture();
  const GeneralisedHarveyShack mean(psd, kParabola, aperture, kLambda);
  std::vector<DrawnMirrors::Discs> planes;
  std::vector<FocalDisc> discs;
  std::vector<double> promise;
  for (const double dz : {0.0, 0.7 * kWave, 2 * kWave}) {
    const MeanSpot spot = mean.at_plane(dz);
    DrawnMirrors::Discs plane{dz, {}};
    for (const double fraction : {0.2, 0.4, 0.65, 0.8, 0.9}) {
      const double r = spot.encircled_energy_radius(fraction);
      if (r > kFieldOfView * kLambda * kFocal * cells / kDiameter) continue;
      plane.radius.push_back(r);
      discs.push_back({r, dz});
      promise.push_back(kMargin * std::max(r * spot.encircled_energy_slope(r), 0.35) / 3);
    }
    planes.push_back(plane);
  }
  const RealisationSpread predicted({psd, kParabola, aperture, kLambda, mean}, discs);
  const Eigen::ArrayXd limits =
      Eigen::Map<const Eigen::ArrayXd>(promise.data(), Eigen::Index(promise.size()));
  const double cut = smallest_cut(predicted, limits).frequency;
  DrawnMirrors drawn({psd, kFocal, kDiameter, scene.inner_diameter, kLambda, cells}, {cut});
  const std::vector<Eigen::ArrayXXd> measured = drawn.spread(planes, draws, seed);
  double worst = 0;
  std::size_t at = 0;
  for (std::size_t plane = 0; plane < planes.size(); ++plane)
    for (Eigen::Index d = 0; d < Eigen::Index(planes[plane].radius.size()); ++d)
      worst = std::max(worst, measured[plane](d, 0) / promise[at++]);
  return worst;
}

}  // namespace

TEST(FullStatistics, AtTheChosenCutMirrorsKeepThePromise) {
  std::uint64_t seed = 171;
  for (const Case& scene : twelve_scenes()) {
    const double worst =
        worst_of_promise(scene, std::holds_alternative<UniformPsd>(scene.psd) ? 256 : 128, 100, ++seed);
    std::printf("%-22s %.2f of the promised spread\n", scene.name.c_str(), worst);
    // 100 realisations give a spread to 7 %; the worst of several lies above.
    EXPECT_LE(worst, 1.25) << scene.name;
  }
}

TEST(FullStatistics, MirrorsOfTwelveScenesDifferAsPredicted) {
  std::uint64_t seed = 71;
  double worst = 0;
  for (const Case& scene : twelve_scenes())
    worst = std::max(worst, worst_factor(scene, 128, 400, ++seed, 1.1));
  RecordProperty("worst_factor_in_hundredths", int(100 * worst));
}

// Spreads in percent inside 1, 3, 8, 20 and 35 um, measured by DrawnMirrors on a grid of 512 with 60
// realisations. Other code gave 0.065, 0.096, 0.103, 0.104, 0.041 at 6 /m and 0.021, 0.034, 0.035, 0.036,
// 0.037 at 12 /m.
TEST(RealisationSpread, LargeAnnulusHasTheSpreadThatDrawsHave) {
  const LargeAnnulus scene;
  const struct {
    double cut;
    std::array<double, 5> percent;
  } measured[] = {{3, {0.1295, 0.2081, 0.2188, 0.1003, 0.0451}},
                  {6, {0.0693, 0.1085, 0.1137, 0.0999, 0.0452}},
                  {12, {0.0251, 0.0391, 0.0404, 0.0427, 0.0435}},
                  {25, {0.0065, 0.0102, 0.0107, 0.0111, 0.0113}}};
  for (const auto& row : measured) {
    const Eigen::ArrayXd light = scene.spread.light(row.cut);
    for (int i = 0; i < 5; ++i)
      EXPECT_LT(std::abs(std::log(100 * light[i] / row.percent[std::size_t(i)])), std::log(kSampling))
          << row.cut << " /m, disc " << i;
  }
}

TEST(FullStatistics, LargeAnnulusHasTheSpreadOfSixtyDraws) {
  const LargeAnnulus scene;
  const std::vector<double> cuts{3, 6, 12, 25};
  DrawnMirrors drawn({scene.psd, 5.52, 2.4, 0.8, scene.wavelength, 512}, cuts);
  const Eigen::ArrayXXd measured = drawn.spread({{0, {1e-6, 3e-6, 8e-6, 20e-6, 35e-6}}}, 60, 6)[0];
  for (std::size_t c = 0; c < cuts.size(); ++c) {
    const Eigen::ArrayXd light = scene.spread.light(cuts[c]);
    for (int i = 0; i < 5; ++i)
      EXPECT_LT(std::abs(std::log(light[i] / measured(i, Eigen::Index(c)))), std::log(kPromisedFactor))
          << cuts[c] << " /m, disc " << i;
  }
}

// Roughness so faint that the first order is all. Reference: the gradient of evaluate_diffraction,
// transformed here, for an aperture without rotational symmetry.
TEST(RealisationSpread, FirstOrderIsTheTransformOfTheGradient) {
  const Aperture aperture = RectangleAperture{0.4, 0.3};
  const RadialPsd psd(UniformPsd{1e-13, 12, 20});
  const GeneralisedHarveyShack mean(psd, kParabola, aperture, kLambda);
  const double dz = 1.5 * kWave, radius = 12e-6;
  const RealisationSpread spread({psd, kParabola, aperture, kLambda, mean}, {{radius, dz}});
  const DiffractionPupil pupil = diffraction_pupil(aperture, kFocal, 0.4 / 160);
  const DiffractionProblem problem{pupil, kFocal, kLambda};
  Eigen::VectorXd value;
  std::vector<Eigen::ArrayXd> gradient;
  ASSERT_TRUE(evaluate_diffraction(problem, Eigen::ArrayXd::Zero(pupil.sample.size()),
                                   {RingThrough{radius, dz}}, 1, nullptr, &value, &gradient));
  constexpr int kRings = 40, kDirections = 48;
  double variance = 0;
  for (int i = 0; i < kRings; ++i) {
    const double f = 12 + 8 * (i + 0.5) / kRings;
    double mean_square = 0;
    for (int a = 0; a < kDirections; ++a) {
      const double angle = pi * (a + 0.5) / kDirections;
      std::complex<double> sum = 0;
      for (Eigen::Index k = 0; k < pupil.sample.size(); ++k)
        sum +=
            gradient[0][k] *
            std::polar(1.0, -2 * pi * f *
                                (pupil.sample.x[k] * std::cos(angle) + pupil.sample.y[k] * std::sin(angle)));
      mean_square += std::norm(sum) / kDirections;
    }
    variance += 2 * pi * f * psd(f) * mean_square * 8 / kRings;
  }
  EXPECT_GT(variance, 0);
  // Error of linear bins of distance on a grid of 64, and of positions in P for those on the mirror.
  EXPECT_NEAR(spread.light(0)[0] / std::sqrt(variance), 1, 0.02);
}

TEST(RealisationSpread, FallsWithTheCutToNothingAtTheTopOfTheBand) {
  const LargeAnnulus scene;
  double last = 1;
  for (double cut = 0.8; cut < 200; cut *= 1.013) {
    const double light = scene.spread.light(cut)[2];
    EXPECT_LE(light, last * (1 + 1e-12));
    EXPECT_GT(light, 0);
    last = light;
  }
  EXPECT_EQ(scene.spread.light(200).maxCoeff(), 0);
  EXPECT_EQ(scene.spread.light(1000).maxCoeff(), 0);
  EXPECT_EQ(scene.spread.rms_height(200), 0);
  EXPECT_EQ(scene.spread.rms_slope(300), 0);
  EXPECT_EQ(scene.spread.lowest(), 0.8);
  EXPECT_EQ(scene.spread.highest(), 200);
}

TEST(RealisationSpread, HasNoJumpsAtThePanels) {
  const LargeAnnulus scene;
  const std::vector<double>& edges = scene.spread.edges();
  for (std::size_t i = 1; i + 1 < edges.size(); ++i) {
    const Eigen::ArrayXd before = scene.spread.light(edges[i] * (1 - 1e-9)),
                         after = scene.spread.light(edges[i] * (1 + 1e-9));
    EXPECT_LT((before / after - 1).abs().maxCoeff(), 1e-6) << edges[i];
  }
}

TEST(RealisationSpread, HoldsForAnyNumberOfThreads) {
  const RadialPsd psd(KCorrelationPsd{height_of(1), 0.1, 2.8, 2.5, 60});
  const Aperture aperture = CircleAperture{kDiameter};
  const GeneralisedHarveyShack mean(psd, kParabola, aperture, kLambda);
  std::vector<FocalDisc> discs;
  for (const double dz : {-kWave, 0.0, 0.5 * kWave, 2 * kWave})
    for (const double r : {4e-6, 15e-6}) discs.push_back({r, dz});
  const SpreadProblem problem{psd, kParabola, aperture, kLambda, mean};
  const RealisationSpread one(problem, discs, 1), three(problem, discs, 3);
  EXPECT_TRUE((one.light(6) == three.light(6)).all());
  EXPECT_TRUE((one.light(6) > 0).all());
}

// A cubic replaces the fifth power of the frequency on the panel that contains the cut.
constexpr double kPartOfPanel = 1e-9;

TEST(RealisationSpread, HeightsAndSlopesOfAUniformBandHaveClosedForms) {
  const double low = 2.5, high = 60, rms = height_of(1), area = pi * kDiameter * kDiameter / 4;
  const RadialPsd psd(UniformPsd{rms, low, high});
  const Aperture aperture = CircleAperture{kDiameter};
  const GeneralisedHarveyShack mean(psd, kParabola, aperture, kLambda);
  const RealisationSpread spread({psd, kParabola, aperture, kLambda, mean}, {});
  const double level = rms * rms / (pi * (high * high - low * low));
  for (const double cut : {2.5, 3.3, 17.0, 55.5}) {
    const double of_variance = std::sqrt(2 / area * level * level * pi * (high * high - cut * cut));
    EXPECT_NEAR(spread.rms_height(cut), of_variance / (2 * rms * rms), kPartOfPanel);
    const double slopes = level * std::pow(2 * pi, 2) * pi / 2 * (std::pow(high, 4) - std::pow(low, 4));
    const double of_slopes = std::sqrt(2 / area * std::pow(2 * pi, 4) * level * level * pi / 3 *
                                       (std::pow(high, 6) - std::pow(cut, 6)));
    EXPECT_NEAR(spread.rms_slope(cut), of_slopes / (2 * slopes), kPartOfPanel);
  }
}

TEST(SmallestCut, MeetsTheLimitAndNotOneCycleLess) {
  const LargeAnnulus scene;
  const Eigen::ArrayXd limits = Eigen::ArrayXd::Constant(5, 0.0035 / 3);
  const SmallestCut cut = smallest_cut(scene.spread, limits);
  EXPECT_FALSE(cut.whole_band);
  // PHYSICS 10: 14 cycles are enough.
  EXPECT_GT(cut.frequency * 2.4, 10);
  EXPECT_LT(cut.frequency * 2.4, 15);
  EXPECT_NEAR(scene.spread.light(cut.frequency)[cut.disc] / limits[cut.disc], 1, 1e-9);
  EXPECT_LT((scene.spread.light(cut.frequency) / limits).maxCoeff(), 1 + 1e-9);
  EXPECT_GT((scene.spread.light(cut.frequency - 1 / 2.4) / limits).maxCoeff(), 1);
}

// Width of the band that is left to scatter, where the limit alone would leave `met`, in cycles across.
TEST(SmallestCut, LeavesNoRestNarrowerThanTheApertureResolves) {
  constexpr double kTop = 60, kCycle = 1 / kDiameter;
  const RadialPsd psd(UniformPsd{height_of(2), 2.5, kTop});
  const Aperture aperture = CircleAperture{kDiameter};
  const GeneralisedHarveyShack mean(psd, kParabola, aperture, kLambda);
  const RealisationSpread spread({psd, kParabola, aperture, kLambda, mean}, {{20e-6, 0}});
  struct Row {
    double met, left;
  };
  for (const auto [met, left] :
       {Row{1e-3, 0}, {0.3, 0}, {0.5, 0}, {0.6, 0.2}, {0.75, 0.5}, {0.95, 0.9}, {1, 1}, {1.2, 1.2}, {3, 3}}) {
    const Eigen::ArrayXd limits = spread.light(kTop - met * kCycle);
    const SmallestCut cut = smallest_cut(spread, limits);
    EXPECT_NEAR((kTop - cut.frequency) / kCycle, left, 1e-6) << met;
    EXPECT_NEAR(cut.share_of_limit, spread.light(kTop - left * kCycle)[0] / limits[0], 1e-6) << met;
  }
}

TEST(SmallestCut, IsTheWholeBandOfAFaintRoughness) {
  const RadialPsd psd(KCorrelationPsd{height_of(0.003), 0.1, 2.8, 2.5, 60});
  const Aperture aperture = CircleAperture{kDiameter};
  const GeneralisedHarveyShack mean(psd, kParabola, aperture, kLambda);
  const RealisationSpread spread({psd, kParabola, aperture, kLambda, mean}, {{5e-6, 0}, {10e-6, 0}});
  const Eigen::ArrayXd limits = Eigen::ArrayXd::Constant(2, 0.001);
  const SmallestCut cut = smallest_cut(spread, limits);
  EXPECT_TRUE(cut.whole_band);
  EXPECT_EQ(cut.frequency, 2.5);
  EXPECT_LT(cut.share_of_limit, 1);
  EXPECT_GT(cut.share_of_limit, 0);
}

TEST(SmallestCut, MovesSmoothlyWithTheRoughness) {
  const Aperture aperture = CircleAperture{kDiameter};
  const Eigen::ArrayXd limits = Eigen::ArrayXd::Constant(3, 0.001);
  std::vector<double> cuts;
  constexpr double kStep = 1.002;
  for (int i = 0; i < 40; ++i) {
    const RadialPsd psd(KCorrelationPsd{height_of(0.9 * std::pow(kStep, i)), 0.1, 2.8, 2.5, 60});
    const GeneralisedHarveyShack mean(psd, kParabola, aperture, kLambda);
    const RealisationSpread spread({psd, kParabola, aperture, kLambda, mean},
                                   {{5e-6, 0}, {10e-6, 0}, {20e-6, 0.7 * kWave}});
    cuts.push_back(smallest_cut(spread, limits).frequency);
  }
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    EXPECT_GT(cuts[i], cuts[i - 1]);
    EXPECT_LT(cuts[i] / cuts[i - 1], std::pow(kStep, 4)) << i;
  }
}

TEST(RealisationSpread, RefusesWhatItCannotUse) {
  const RadialPsd psd(UniformPsd{1e-9, 2.5, 60});
  const Aperture aperture = CircleAperture{kDiameter};
  const GeneralisedHarveyShack mean(psd, kParabola, aperture, kLambda);
  const SpreadProblem problem{psd, kParabola, aperture, kLambda, mean};
  EXPECT_THROW(RealisationSpread(problem, {{0, 0}}), std::invalid_argument);
  EXPECT_THROW(RealisationSpread(problem, {{1e-5, -kFocal}}), ComputationError);
  EXPECT_THROW(RealisationSpread(problem, {{1e-5, std::nan("")}}), ComputationError);
  const RealisationSpread spread(problem, {{1e-5, 0}});
  EXPECT_THROW(smallest_cut(spread, {}), std::invalid_argument);
  EXPECT_THROW(smallest_cut(spread, Eigen::ArrayXd::Zero(1)), std::invalid_argument);
}
