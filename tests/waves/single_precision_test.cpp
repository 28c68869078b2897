// Compares wave optics in single and double precision.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "aberfit/core/random.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {
namespace {

constexpr double kFocal = 2.8, kWave = 632.8e-9, kAcross = 0.4, kGrain = kWave * kFocal / kAcross;

// A sum of plane waves; the spot has about `g` times 2 speckles.
Eigen::ArrayXd rough(const DiffractionPupil& pupil, double g, std::uint64_t seed) {
  constexpr int kModes = 60;
  constexpr double kCycles = 5, kTurn = 2 * std::numbers::pi;
  const RandomStream stream(seed, "single-precision");
  Eigen::ArrayXd height = Eigen::ArrayXd::Zero(pupil.sample.size());
  for (int k = 0; k < kModes; ++k) {
    const auto draw = [&](int i) { return stream.uniform(std::uint64_t(3 * k + i)); };
    const double f = kTurn * kCycles / kAcross * std::sqrt(draw(0)), turn = kTurn * draw(1);
    height +=
        (f * (std::cos(turn) * pupil.sample.x + std::sin(turn) * pupil.sample.y) + kTurn * draw(2)).cos();
  }
  return g * kWave / (4 * std::numbers::pi) * std::sqrt(2.0 / kModes) * height;
}

struct Light {
  Eigen::VectorXd values;
  std::vector<Eigen::ArrayXd> gradients;
};

// Statistics of every kind, in focus and out, with their allowed errors: 2e-7 of the total energy, over the
// normalisation of the statistic.
struct Case {
  Statistic statistic;
  double error;
};
std::vector<Case> cases() {
  constexpr double kOfLight = 2e-7;
  std::vector<Case> all;
  for (const double dz : {0.0, 1e-3, -2e-3}) {
    all.push_back({RingThrough{4 * kGrain, dz}, kOfLight});
    all.push_back({EncircledEnergyRadius{0.5, dz}, 3 * kOfLight * 10 * kGrain});
    all.push_back({EncircledEnergyRadius{0.9, dz}, 10 * kOfLight * 20 * kGrain});
  }
  all.push_back({EnsquaredThrough{12 * kGrain, 0}, kOfLight});
  all.push_back({StrehlRatio{}, kOfLight});
  all.push_back({ModulationTransfer{0.02 / kGrain}, kOfLight});
  all.push_back({SpotFwhm{2 * kGrain}, 10 * kOfLight * 20 * kGrain});
  all.push_back({RingFwhm{0.9, {}}, 1e-6 * 2 * 20 * kGrain * kFocal / (0.5 * kAcross)});
  return all;
}

TEST(SinglePrecision, RoundsTheLightByAMillionth) {
  const std::vector<Case> asked = cases();
  std::vector<Statistic> statistics;
  for (const Case& one : asked) statistics.push_back(one.statistic);
  const DiffractionPupil pupil = diffraction_pupil(CircleAperture{kAcross}, kFocal, kAcross / 192);
  for (const double g : {1.5, 4.0}) {
    const Eigen::ArrayXd height = rough(pupil, g, 1);
    const auto light = [&](bool single, DiffractionWorkspace* workspace, int threads) {
      DiffractionProblem problem{pupil, kFocal, kWave};
      problem.single_precision = single;
      Light result;
      EXPECT_TRUE(evaluate_diffraction(problem, height, statistics, threads, workspace, &result.values,
                                       &result.gradients));
      return result;
    };
    const Light exact = light(false, nullptr, 2), rounded = light(true, nullptr, 2);
    double largest = 0;
    for (std::size_t k = 0; k < asked.size(); ++k) {
      const auto i = Eigen::Index(k);
      EXPECT_NEAR(rounded.values[i], exact.values[i], asked[k].error) << k << " g " << g;
      largest = std::max(largest, std::abs(rounded.values[i] / exact.values[i] - 1));
      EXPECT_LT((rounded.gradients[k] - exact.gradients[k]).matrix().norm(),
                2e-5 * exact.gradients[k].matrix().norm())
          << k << " g " << g;
    }
    EXPECT_GT(largest, 1e-12);  // shows that the precision differs
    // A workspace must not mix the two precisions, and threads must change nothing.
    DiffractionWorkspace workspace;
    for (const bool single : {false, true, true, false}) {
      const Light again = light(single, &workspace, 3);
      const Light& expected = single ? rounded : exact;
      EXPECT_TRUE(again.values == expected.values) << single;
      for (std::size_t k = 0; k < asked.size(); ++k)
        EXPECT_TRUE((again.gradients[k] == expected.gradients[k]).all()) << single << ' ' << k;
    }
  }
}

}  // namespace
}  // namespace aberfit
