// Light in wide circles, sampled once a grain, against transforms that hold every lag: the law of the noise
// that this brings, where it is not taken, and its derivatives.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "aberfit/core/random.h"
#include "aberfit/waves/diffraction_psf.h"
#include "short_form.h"

namespace aberfit {
namespace {

constexpr double kPi = std::numbers::pi, kFocal = 3, kWave = 500e-9, kAcross = 0.3;

// A rough surface of g = 4 pi rms/wavelength by plane waves of up to `cycles` across.
Eigen::ArrayXd rough(const DiffractionPupil& pupil, double g, double cycles, std::uint64_t seed) {
  constexpr int kModes = 100;
  const RandomStream stream(seed, "wide-circles");
  const double amplitude = g * kWave / (4 * kPi) * std::sqrt(2.0 / kModes);
  Eigen::ArrayXd height = Eigen::ArrayXd::Zero(pupil.sample.size());
  for (int k = 0; k < kModes; ++k) {
    const auto draw = [&](int i) { return stream.uniform(std::uint64_t(3 * k + i)); };
    const double f = cycles / kAcross * std::sqrt(draw(0)), turn = 2 * kPi * draw(1),
                 phase = 2 * kPi * draw(2);
    height +=
        amplitude *
        (2 * kPi * f * (std::cos(turn) * pupil.sample.x + std::sin(turn) * pupil.sample.y) + phase).cos();
  }
  return height;
}

// Standard deviation of the spot in grains of kAcross: g times the RMS frequency along an axis.
double spot_in_grains(double g, double cycles) { return 0.5 * g * cycles; }

struct Scene {
  std::string name;
  Aperture aperture;
  double width, g, cycles;
};

std::vector<Statistic> circles_of(const Scene& s, double dz) {
  std::vector<Statistic> circles;
  for (const double part : {0.3, 0.6, 1.0, 1.7, 2.5})
    circles.push_back(RingThrough{part * spot_in_grains(s.g, s.cycles) * kWave * kFocal / kAcross, dz});
  return circles;
}

DiffractionPupil pupil_of(const Scene& s) {
  constexpr double kRoom = 9;  // of standard deviations
  return diffraction_pupil(s.aperture, kParaxial, kAcross / std::ceil(kRoom * spot_in_grains(s.g, s.cycles)));
}

const std::vector<Scene>& scenes() {
  static const std::vector<Scene> all = {{"circle", CircleAperture{kAcross}, kAcross, 4, 12},
                                         {"circle", CircleAperture{kAcross}, kAcross, 16, 6},
                                         {"annulus", AnnulusAperture{kAcross, 0.15}, kAcross, 8, 6},
                                         {"rectangle", RectangleAperture{kAcross, 0.15}, 0.15, 8, 12}};
  return all;
}

// Root mean square over draws and circles of the change, over the law; and the largest change. In focus, and
// where defocus makes the spot three times as wide, and the noise less.
TEST_WITH_SHORT_FORM(WideCircles, DifferByTheNoiseOfTheirEdge) {
  const int draws = whole ? 6 : 2;
  constexpr double kNear = 0.02;  // of a radius: for r dE/dr
  for (const Scene& s : test::all_or_few(whole, scenes(), {0, 2}))
    for (const double blur : {0.0, 4.0}) {  // of the rim, in standard deviations of the spot
      const double spot = spot_in_grains(s.g, s.cycles) * kWave * kFocal / kAcross,
                   dz = blur * spot * kFocal / (0.5 * kAcross);
      const DiffractionPupil pupil = diffraction_pupil(
          s.aperture, kParaxial, kAcross / std::ceil((9 + 2 * blur) * spot_in_grains(s.g, s.cycles)));
      std::vector<Statistic> circles;
      for (const double part : {0.3, 0.6, 1.0, 1.7, 2.5})
        for (const double beside : {1.0, 1 - kNear, 1 + kNear})
          circles.push_back(RingThrough{part * beside * std::hypot(1, 0.5 * blur) * spot, dz});
      double squares = 0, largest = 0;
      for (int seed = 0; seed < draws; ++seed) {
        const Eigen::ArrayXd height = rough(pupil, s.g, s.cycles, std::uint64_t(seed));
        DiffractionProblem problem{pupil, kFocal, kWave};
        problem.aliased_limit = 1e-2;
        Eigen::VectorXd exact, wide;
        ASSERT_TRUE(evaluate_diffraction(problem, height, circles, 2, nullptr, &exact, nullptr)) << s.name;
        problem.wide_circles = 0;
        ASSERT_TRUE(evaluate_diffraction(problem, height, circles, 2, nullptr, &wide, nullptr)) << s.name;
        for (Eigen::Index k = 0; k < exact.size(); k += 3) {
          const double curve = (exact[k + 2] - exact[k + 1]) / (2 * kNear),
                       grains = std::get<RingThrough>(circles[std::size_t(k)]).ring_radius * s.width /
                                (kWave * (kFocal + dz));
          const double law = kWideCircleNoise * std::max(curve, kFlattestCurve) * std::pow(grains, -1.5);
          const double off = std::abs(wide[k] - exact[k]) / law;
          squares += 3 * off * off / (draws * double(circles.size()));
          largest = std::max(largest, off);
        }
      }
      EXPECT_LT(std::sqrt(squares), 1.0) << s.name << ", g " << s.g << ", blur " << blur;
      if (blur == 0) {
        EXPECT_GT(std::sqrt(squares), 0.2) << s.name << ", g " << s.g;
      }
      EXPECT_LT(largest, 3.0) << s.name << ", g " << s.g << ", blur " << blur;
    }
}

// Values, then gradients of the same surface in the same workspace, then another surface, then none wide; by
// one thread and three.
TEST(WideCircles, AreTheSameInAWorkspaceAndForAnyThreadCount) {
  const Scene& s = scenes()[2];
  const DiffractionPupil pupil = pupil_of(s);
  std::vector<Statistic> statistics = circles_of(s, 2e-4);
  for (const Statistic& circle : circles_of(s, 0)) statistics.push_back(circle);
  statistics.push_back(RingFwhm{0.9, {}});
  DiffractionWorkspace workspace;
  for (const double wide : {0.0, 0.0, HUGE_VAL, 0.0})
    for (const std::uint64_t seed : {1, 1, 2}) {
      const Eigen::ArrayXd height = rough(pupil, s.g, s.cycles, seed);
      DiffractionProblem problem{pupil, kFocal, kWave};
      problem.aliased_limit = 1e-2;
      problem.wide_circles = wide;
      Eigen::VectorXd alone, kept;
      std::vector<Eigen::ArrayXd> gradients, gradients_kept;
      evaluate_diffraction(problem, height, statistics, 1, nullptr, &alone, &gradients);
      evaluate_diffraction(problem, height, statistics, 3, &workspace, &kept, nullptr);
      EXPECT_TRUE(alone == kept) << wide << ' ' << seed;
      evaluate_diffraction(problem, height, statistics, 2, &workspace, &kept, &gradients_kept);
      EXPECT_TRUE(alone == kept) << wide << ' ' << seed;
      for (std::size_t k = 0; k < gradients.size(); ++k)
        EXPECT_TRUE((gradients[k] == gradients_kept[k]).all()) << wide << ' ' << seed << ' ' << k;
    }
}

// A narrow circle in the plane, or anything else, keeps all of the plane exact.
TEST(WideCircles, AreTakenWhereAllOfThePlaneIsWide) {
  const Scene& s = scenes()[0];
  const DiffractionPupil pupil = pupil_of(s);
  const Eigen::ArrayXd height = rough(pupil, s.g, s.cycles, 1);
  const double grain = kWave * kFocal / kAcross;
  const auto values = [&](double wide, const std::vector<Statistic>& statistics) {
    DiffractionProblem problem{pupil, kFocal, kWave};
    problem.aliased_limit = 1e-2;
    problem.wide_circles = wide * kWave / kAcross;
    Eigen::VectorXd result;
    evaluate_diffraction(problem, height, statistics, 1, nullptr, &result, nullptr);
    return result;
  };
  const Statistic at_30 = RingThrough{30 * grain, 0}, at_20 = RingThrough{20 * grain, 0},
                  share = EncircledEnergyRadius{0.6, 0}, peak = StrehlRatio{};
  const double exact = values(HUGE_VAL, {at_30})[0];
  EXPECT_NE(values(25, {at_30})[0], exact);
  EXPECT_NE(values(25, {at_30, share})[0], exact);
  EXPECT_EQ(values(35, {at_30})[0], exact);
  EXPECT_EQ(values(25, {at_30, at_20})[0], exact);
  EXPECT_EQ(values(25, {at_30, peak})[0], exact);
  EXPECT_EQ(values(25, {share})[0], values(HUGE_VAL, {share})[0]);
}

// Against central differences along a random direction: rounding 1e-16/1e-6, truncation 1e-12 of the third
// derivative.
TEST(WideCircles, HaveTheDerivativesOfTheirValues) {
  const Scene& s = scenes()[2];
  const DiffractionPupil pupil = pupil_of(s);
  const Eigen::ArrayXd height = rough(pupil, s.g, s.cycles, 2), along = rough(pupil, 1, s.cycles, 3);
  std::vector<Statistic> statistics = circles_of(s, 2e-4);
  statistics.push_back(RingFwhm{0.9, {}});
  const auto values = [&](double step, std::vector<Eigen::ArrayXd>* gradients) {
    DiffractionProblem problem{pupil, kFocal, kWave};
    problem.aliased_limit = 1e-2;
    problem.wide_circles = 0;
    Eigen::VectorXd result;
    evaluate_diffraction(problem, height + step * along, statistics, 2, nullptr, &result, gradients);
    return result;
  };
  std::vector<Eigen::ArrayXd> gradients;
  values(0, &gradients);
  constexpr double kStep = 1e-4;
  const Eigen::VectorXd differences = (values(kStep, nullptr) - values(-kStep, nullptr)) / (2 * kStep);
  for (std::size_t k = 0; k < statistics.size(); ++k)
    EXPECT_NEAR((gradients[k] * along).sum(), differences[Eigen::Index(k)],
                1e-5 * differences.cwiseAbs().maxCoeff())
        << k;
}

}  // namespace
}  // namespace aberfit
