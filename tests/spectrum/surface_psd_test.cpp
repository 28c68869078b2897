// Tests surface PSDs and drawing lines from random profiles of known PSD, sampled as heights or slopes.
#include "aberfit/spectrum/surface_psd.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "aberfit/core/parallel.h"
#include "short_form.h"
#include "spectrum/random_line.h"

namespace aberfit {
namespace {

using Eigen::Index;
using test::random_line;
using test::Spectrum;
constexpr double kPi = std::numbers::pi;
constexpr double kPitch = test::kLinePitch;
constexpr int kFewProfiles = 100, kAllProfiles = 500;
const std::size_t kFewScenes[] = {
    2, 3};  // the steepest line and the knee, one tested with heights and one with slopes

struct Moments {
  double mean = 0, deviation = 0;
};
Moments moments(const std::vector<double>& values) {
  double sum = 0, square = 0;
  for (const double value : values) sum += value;
  const double mean = sum / double(values.size());
  for (const double value : values) square += (value - mean) * (value - mean);
  return {mean, std::sqrt(square / double(values.size() - 1))};
}

struct Scene {
  std::string name;
  Spectrum spectrum;
  double exponent = NAN;  // of the line, if there is one
};
std::vector<Scene> scenes() {
  std::vector<Scene> all;
  for (const double exponent : {2.0, 3.0, 4.0})
    all.push_back(
        {fmt::format("f^-{}", exponent), [=](double f) { return 1e-15 * std::pow(f, -exponent); }, exponent});
  all.push_back({"knee at 20/m", [](double f) { return 1e-18 * std::pow(1 + 0.0025 * f * f, -1.5); }});
  all.push_back({"floor", [](double f) { return 1e-15 * std::pow(f, -3) + 1e-21; }});
  return all;
}

// Prints bias over the standard error of one profile, and coverage. wider: extra tolerance for few profiles.
// These use heights of one scene and slopes of another.
void expect_surface(int profiles, double wider) {
  for (const ProfileQuantity quantity : {ProfileQuantity::kHeight, ProfileQuantity::kSlope})
    for (const Scene& scene :
         test::all_or_few(profiles == kAllProfiles, scenes(), {kFewScenes[int(quantity)]})) {
      const PsdEstimator estimator(random_line(scene.spectrum, quantity, 0), {}, 1);
      std::vector<PsdEstimate> estimates(static_cast<std::size_t>(profiles));
      std::vector<SurfacePsd> surfaces(estimates.size());
      std::vector<DrawingLine> lines(estimates.size());
      parallel_for(estimates.size(), 2, [&](std::size_t i) {
        estimates[i] = estimator(random_line(scene.spectrum, quantity, int(i) + 1));
        const PsdModelFit fit = fit_psd_model(estimates[i]);
        surfaces[i] = surface_psd(estimates[i], fit);
        lines[i] = drawing_line(estimates[i], fit.f_min, fit.f_max);
      });
      const std::string where = (quantity == ProfileQuantity::kSlope ? "slopes, " : "heights, ") + scene.name;
      std::vector<std::vector<double>> ratio(std::size_t(estimates[0].psd.size()));
      double covered = 0, looks = 0, worst = 0;
      for (const SurfacePsd& surface : surfaces)
        for (Index b = 0; b < surface.psd.size(); ++b) {
          const double truth = scene.spectrum(surface.frequency[b]);
          ratio[std::size_t(surface.bin[std::size_t(b)])].push_back(surface.psd[b] / truth);
          covered += surface.lower[b] <= truth && truth <= surface.upper[b];
          ++looks;
        }
      for (const std::vector<double>& bin : ratio) {
        if (double(bin.size()) < 0.9 * profiles) continue;
        const Moments of_bin = moments(bin);
        worst = std::max(worst, std::abs(of_bin.mean - 1) / of_bin.deviation);
      }
      fmt::print("{:24} bins: bias {:.2f} standard errors at most, covered {:.3f}\n", where, worst,
                 covered / looks);
      EXPECT_LT(worst, 0.2 + wider * 0.25) << where;  // the largest of about thirty
      EXPECT_GE(covered / looks, 0.94) << where;
      EXPECT_LE(covered / looks, 0.97) << where;
      if (!std::isfinite(scene.exponent)) continue;
      std::vector<double> exponents;
      double inside = 0;
      for (const DrawingLine& line : lines) {
        exponents.push_back(line.exponent);
        inside += line.lower <= scene.exponent && scene.exponent <= line.upper;
      }
      const Moments line = moments(exponents);
      fmt::print("{:24} line: B = {:.4f} +- {:.4f}, covered {:.3f}\n", where, line.mean, line.deviation,
                 inside / profiles);
      EXPECT_LT(std::abs(line.mean - scene.exponent), (0.2 + wider * 0.1) * line.deviation) << where;
      EXPECT_GE(inside / profiles, 0.91 - wider * 0.04) << where;
      EXPECT_LE(inside / profiles, 0.98 + wider * 0.02) << where;
    }
}

TEST(SurfacePsd, BinsAndLineAreTheSurfacesForHeightsAndSlopes) { expect_surface(kFewProfiles, 1); }

// Takes minutes: only with `ctest -C statistics -L statistics`.
TEST(FullStatistics, BinsAndLineAreTheSurfacesForHeightsAndSlopes) { expect_surface(kAllProfiles, 0); }

TEST(SurfacePsd, LeavesOutWhatIntegrationOfSlopesDoesNotLet) {
  const Spectrum steep = scenes()[1].spectrum;
  const PsdEstimate slopes = estimate_psd(random_line(steep, ProfileQuantity::kSlope, 3), {});
  const PsdEstimate heights = estimate_psd(random_line(steep, ProfileQuantity::kHeight, 3), {});
  // x cot x = sqrt(0.1) at x = 1.3397 = pi f pitch.
  EXPECT_NEAR(slopes.high.tail(1)[0], 1.3397 / kPi / kPitch, 2 * slopes.resolution);
  EXPECT_GT(heights.frequency.tail(1)[0], 0.95 * heights.nyquist);
}

TEST(DrawingLine, OfWhatIsNoLineSaysSoWithItsFactor) {
  constexpr int kLines = 8;
  double off = 0;  // averaged, because the factor of one realisation may be 1 by chance
  for (int seed = 1; seed <= kLines; ++seed) {
    const Profile profile = random_line([](double f) { return 1e-18 / std::pow(1 + f * f / 3600, 3); },
                                        ProfileQuantity::kHeight, seed);
    const DrawingLine line = drawing_line(estimate_psd(profile, {}), 2, 400);
    EXPECT_FALSE(line.describes) << seed;
    off += std::abs(std::log(line.factor)) / kLines;
  }
  EXPECT_GT(off, 0.1);
  const PsdEstimate straight =
      estimate_psd(random_line(scenes()[1].spectrum, ProfileQuantity::kHeight, 5), {});
  EXPECT_TRUE(drawing_line(straight, 2, 400).describes);
}

// A / f^3 from f1 to f2 has the variance A (f1^-2 - f2^-2) / 2 and mean square slope (2 pi)^2 A log(f2 / f1).
TEST(SurfacePsd, RmsInABandIsThatOfThePowerLaw) {
  SurfacePsd surface;
  const Eigen::ArrayXd edge = Eigen::ArrayXd::LinSpaced(2001, std::log(10.0), std::log(200.0)).exp();
  surface.low = edge.head(2000), surface.high = edge.tail(2000);
  surface.frequency = (surface.low * surface.high).sqrt();
  surface.psd = 1e-15 * surface.frequency.pow(-3);
  surface.model = 4 * surface.psd;
  const BandRms rms = rms_in_band(surface, PsdTableKind::k1dOneSided, false, 0, 1e9);
  EXPECT_NEAR(rms.height, std::sqrt(0.5e-15 * (1e-2 - 0.25e-4)), 1e-5 * rms.height);
  EXPECT_NEAR(rms.slope, 2 * kPi * std::sqrt(1e-15 * std::log(20.0)), 1e-5 * rms.slope);
  EXPECT_NEAR(rms_in_band(surface, PsdTableKind::k1dOneSided, true, 0, 1e9).height, 2 * rms.height, 1e-15);
}

// A band may end inside a bin, and the squares of adjoining bands add up to the whole.
TEST(SurfacePsd, BandsThatEndInsideBinsAreExactForAPowerLawAndAddUp) {
  SurfacePsd surface;
  const Eigen::ArrayXd edge = Eigen::ArrayXd::LinSpaced(13, std::log(10.0), std::log(100.0)).exp();
  surface.low = edge.head(12), surface.high = edge.tail(12);
  surface.frequency = (surface.low + surface.high) / 2;
  surface.psd = surface.model = 1e-15 * surface.frequency.pow(-3);
  for (const PsdTableKind kind : {PsdTableKind::k1dOneSided, PsdTableKind::k2dTwoSided}) {
    const bool profile = kind == PsdTableKind::k1dOneSided;
    const BandContent mid = band_content(surface, kind, {"mid", 17, 55});
    EXPECT_EQ(mid.from, 17);
    EXPECT_EQ(mid.to, 55);
    const double variance =
        profile ? 0.5e-15 * (1 / (17.0 * 17) - 1 / (55.0 * 55)) : 2 * kPi * 1e-15 * (1 / 17.0 - 1 / 55.0);
    const double slope = profile ? 4 * kPi * kPi * 1e-15 * std::log(55 / 17.0)
                                 : 0.5 * 4 * kPi * kPi * 2 * kPi * 1e-15 * (55 - 17);
    EXPECT_NEAR(mid.data.height, std::sqrt(variance), 1e-9 * mid.data.height);
    EXPECT_NEAR(mid.model.slope, std::sqrt(slope), 1e-9 * mid.model.slope);
    double sum = 0;
    const std::vector<BandContent> all = octaves(surface, kind);
    ASSERT_EQ(all.size(), 4u);  // 8, 16, 32, 64 to 128
    EXPECT_NEAR(all.front().from, 10, 1e-9);
    EXPECT_NEAR(all.back().to, 100, 1e-9);
    for (const BandContent& octave : all) sum += octave.data.height * octave.data.height;
    const double whole = rms_in_band(surface, kind, false, 0, 1e9).height;
    EXPECT_NEAR(std::sqrt(sum), whole, 1e-12 * whole);
  }
  EXPECT_EQ(band_content(surface, PsdTableKind::k1dOneSided, {"fine", 200, 300}).to, 0);
}

// The band's fraction of known spectra, from random lines; the band ends inside bins.
TEST_WITH_SHORT_FORM(SurfacePsd, RmsInABandIsThatOfTheEnsemble) {
  const Spectrum spectrum = scenes()[1].spectrum;  // 1e-15 f^-3
  const int lines = whole ? 60 : 20;
  double data = 0, model = 0, square = 0;
  for (int i = 1; i <= lines; ++i) {
    const PsdEstimate estimate = estimate_psd(random_line(spectrum, ProfileQuantity::kHeight, i), {});
    const SurfacePsd surface = surface_psd(estimate, fit_psd_model(estimate));
    const BandContent band = band_content(surface, estimate.kind, {"mid", 23, 111});
    const double share = std::pow(band.data.height, 2) / (0.5e-15 * (1 / (23.0 * 23) - 1 / (111.0 * 111)));
    data += share / lines, square += share * share / lines;
    model += std::pow(band.model.height, 2) / (0.5e-15 * (1 / (23.0 * 23) - 1 / (111.0 * 111))) / lines;
  }
  EXPECT_NEAR(data, 1, 3.5 * std::sqrt((square - data * data) / lines) + 0.01);
  EXPECT_NEAR(model, 1, 0.05 * std::sqrt(60.0 / lines));
}

// Bins of G = 2e-15 f^-2.5 from 100 to 1000 /m; the requested band starts below them.
TEST(LineAsMeasured, HasTheMomentsOfItsBinsWhereThereAreBins) {
  constexpr Index kBins = 24;
  SurfacePsd surface;
  for (Eigen::ArrayXd* edge : {&surface.low, &surface.high, &surface.frequency, &surface.psd, &surface.dof})
    edge->resize(kBins);
  for (Index b = 0; b < kBins; ++b) {
    surface.low[b] = 100 * std::pow(10, double(b) / kBins);
    surface.high[b] = 100 * std::pow(10, double(b + 1) / kBins);
    surface.frequency[b] = std::sqrt(surface.low[b] * surface.high[b]);
    surface.psd[b] = 2e-15 * std::pow(surface.frequency[b], -2.5);
    surface.dof[b] = 2;
  }
  const DrawingLine line = line_as_measured(surface, PsdTableKind::k1dOneSided, 10, 1000);
  EXPECT_NEAR(line.exponent, 2.5, 1e-6);
  EXPECT_NEAR(line.amplitude / 2e-15, 1, 1e-5);
  EXPECT_NEAR(line.f_min, 100, 1e-9);
  EXPECT_NEAR(line.f_max, 1000, 1e-9);
  surface.psd[0] *= 4;  // one bin too high by chance: more height, and a steeper line for the same slope
  EXPECT_GT(line_as_measured(surface, PsdTableKind::k1dOneSided, 10, 1000).exponent, 2.6);
}

}  // namespace
}  // namespace aberfit
