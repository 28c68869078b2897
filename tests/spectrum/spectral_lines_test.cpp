#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "aberfit/core/random.h"
#include "aberfit/spectrum/psd_estimate.h"
#include "dabam_loader.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

constexpr int kSamples = 256, kWaves = 4 * kSamples / 2;

// Red profiles with S1 = (f/resolution)^-2.5 [m^3], one per column.
Eigen::MatrixXd red_profiles(int count, const std::string& name) {
  Eigen::MatrixXd basis(kSamples, 2 * kWaves), amplitude(2 * kWaves, count);
  for (int w = 0; w < kWaves; ++w) {
    const double u = (w + 0.5) / 4, scale = std::sqrt(std::pow(u, -2.5) / 4);
    for (int i = 0; i < kSamples; ++i)
      basis(i, 2 * w) = scale * std::cos(2 * pi * u * i / kSamples),
                   basis(i, 2 * w + 1) = scale * std::sin(2 * pi * u * i / kSamples);
  }
  const RandomStream stream(1, name);
  for (Eigen::Index i = 0; i < amplitude.size(); ++i) amplitude(i) = stream.normal(std::uint64_t(i));
  return basis * amplitude;
}

Profile profile_of(const Eigen::ArrayXd& value) {
  Profile profile;
  profile.x = Eigen::ArrayXd::LinSpaced(kSamples, 0, kSamples - 1);
  profile.value = value;
  return profile;
}

bool has_line(const PsdEstimate& estimate, double f) {
  for (const SpectralLine& line : estimate.lines)
    if (std::abs(line.frequency - f) <= estimate.resolution) return true;
  return false;
}

}  // namespace

TEST(SpectralLines, FalseAlarmsAreRare) {
  constexpr int kSpectra = 1000;
  const Eigen::MatrixXd all = red_profiles(kSpectra, "FalseAlarmsAreRare");
  const PsdEstimator estimator(profile_of(Eigen::ArrayXd::Zero(kSamples)), {});
  int alarms = 0;
  for (int s = 0; s < kSpectra; ++s) alarms += !estimator(profile_of(all.col(s))).lines.empty();
  EXPECT_LE(alarms, 3);  // at most 1e-3 per spectrum; more than 3 in 1,000 occur in 2 % of tests
}

TEST(SpectralLines, ASineIsFoundWithItsFrequencyAndAmplitude) {
  const Eigen::ArrayXd red = red_profiles(1, "ASine").col(0);
  for (const double u : {40.0, 40.3, 60.5}) {
    const double amplitude = 60 * std::sqrt(std::pow(u, -2.5));
    const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(kSamples, 0, kSamples - 1) / kSamples;
    const PsdEstimate estimate = estimate_psd(profile_of(red + amplitude * (2 * pi * u * t + 0.4).sin()), {});
    ASSERT_EQ(estimate.lines.size(), 1u) << u;
    EXPECT_NEAR(estimate.lines[0].frequency, u / kSamples, 0.2 / kSamples);
    EXPECT_NEAR(estimate.lines[0].rms / (amplitude / std::sqrt(2)), 1, 0.02) << u;
    // The bins equal those of the surface without the line.
    PsdEstimatorOptions keep;
    keep.find_lines = false;
    const PsdEstimate clean = estimate_psd(profile_of(red), keep);
    EXPECT_NEAR(clean.count.sum() - estimate.count.sum(), 5, 1);
    for (Eigen::Index b = 0; b < estimate.psd.size(); ++b)
      for (Eigen::Index c = 0; c < clean.psd.size(); ++c)
        if (estimate.low[b] == clean.low[c]) {
          EXPECT_LT(estimate.psd[b], 2.5 * clean.psd[c]);
        }
  }
}

using SpectralLinesOnRealData = test::DabamOnRealData;

TEST_F(SpectralLinesOnRealData, DabamProfilesShowTheirKnownLines) {
  EXPECT_TRUE(has_line(estimate_psd(test::load_dabam("039"), {}, 2), 125));
  EXPECT_TRUE(has_line(estimate_psd(test::load_dabam("071"), {}, 2), 1095));
}

TEST(SpectralLines, GratingsAndTurningMarksOfMapsAreFound) {
  constexpr int kSide = 96;
  HeightMap map;
  map.pitch_x = map.pitch_y = 1;
  map.height = Grid::Zero(kSide, kSide);
  const RandomStream stream(1, "map");
  for (Eigen::Index i = 0; i < map.height.size(); ++i) map.height(i) = stream.normal(std::uint64_t(i));
  EXPECT_TRUE(estimate_psd(map, {}, 2).lines.empty());
  HeightMap grating = map, turned = map;
  const double u = 21.3, v = -12.6, f = 25.2;
  for (int r = 0; r < kSide; ++r)
    for (int c = 0; c < kSide; ++c) {
      grating.height(r, c) += 0.5 * std::cos(2 * pi * (u * c + v * r) / kSide);
      turned.height(r, c) += 4 * std::cos(2 * pi * f / kSide * std::hypot(c - 47.5, r - 47.5)) /
                             std::sqrt(1 + std::hypot(c - 47.5, r - 47.5));
    }
  const PsdEstimate one = estimate_psd(grating, {}, 2);
  ASSERT_EQ(one.lines.size(), 1u);
  EXPECT_NEAR(one.lines[0].frequency * kSide, std::hypot(u, v), 0.5);
  EXPECT_NEAR(one.lines[0].angle, pi + std::atan2(v, u), 0.02);
  EXPECT_NEAR(one.lines[0].rms / (0.5 / std::sqrt(2)), 1, 0.05);
  const PsdEstimate rings = estimate_psd(turned, {}, 2);
  bool found = false;
  for (const SpectralLine& line : rings.lines)
    found = found || (std::isnan(line.angle) && std::abs(line.frequency * kSide - f) <= 1);
  EXPECT_TRUE(found);
}
