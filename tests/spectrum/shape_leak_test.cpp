// A figure left by detrending leaks into the lowest bins. Tests random profiles and maps of known PSD, with
// and without a cubic or a quartic of many times their height.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "aberfit/core/parallel.h"
#include "aberfit/roughness/random_surface.h"
#include "aberfit/spectrum/psd_model_fit.h"
#include "short_form.h"
#include "spectrum/random_line.h"

namespace aberfit {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using test::random_line;
using test::Spectrum;

bool said(const PsdEstimate& estimate) {
  for (const Warning& warning : estimate.warnings)
    if (warning.code == "shape-leaks") return true;
  return false;
}

Spectrum falling(double exponent) {
  return [=](double f) { return 1e-15 * std::pow(f, -exponent); };
}

// Adds a Legendre polynomial of degree 3 or 4 with `times` the RMS of the line, in the line's quantity.
Profile with_figure(const Profile& line, int degree, double times) {
  const ArrayXd t = 2 * (line.x - line.x[0]) / (line.x.tail(1)[0] - line.x[0]) - 1;
  const double per_x = 2 / (line.x.tail(1)[0] - line.x[0]);
  ArrayXd shape, slope;
  if (degree == 3)
    shape = 2.5 * t.cube() - 1.5 * t, slope = (7.5 * t.square() - 1.5) * per_x;
  else
    shape = (35 * t.pow(4) - 30 * t.square() + 3) / 8, slope = (17.5 * t.cube() - 7.5 * t) * per_x;
  const double size = times * rms(detrend(heights_of(line), {})) * std::sqrt(2 * degree + 1);
  Profile result = line;
  result.value += size * (line.quantity == ProfileQuantity::kSlope ? slope : shape);
  return result;
}

double alarms(int lines, double exponent, ProfileQuantity quantity, int degree) {
  PsdEstimatorOptions options;
  options.detrend.degree = degree;
  const PsdEstimator estimator(random_line(falling(exponent), quantity, 0), options, 1);
  std::vector<char> alarm(static_cast<std::size_t>(lines));
  parallel_for(alarm.size(), 2, [&](std::size_t i) {
    const PsdEstimate estimate = estimator(random_line(falling(exponent), quantity, int(i) + 1));
    alarm[i] = said(estimate);
    EXPECT_EQ(estimate.trusted_from > 0, said(estimate));
  });
  return double(std::count(alarm.begin(), alarm.end(), 1)) / lines;
}

void expect_silence(int lines) {
  double sum = 0, looks = 0;
  for (const ProfileQuantity quantity : {ProfileQuantity::kHeight, ProfileQuantity::kSlope})
    for (const double exponent : {1.0, 2.0, 3.0, 4.0})
      for (const int degree : {1, 2}) {
        const double share = alarms(lines, exponent, quantity, degree);
        fmt::print("f^-{} quantity {} degree {}: {:.4f}\n", exponent, int(quantity), degree, share);
        sum += share, ++looks;
      }
  EXPECT_LT(sum / looks, 0.01);
}
TEST(ShapeLeak, IsNotSeenWhereThereIsNone) { expect_silence(20); }
// Takes minutes: only with `ctest -C statistics -L statistics`.
TEST(FullStatistics, ShapeLeakIsNotSeenWhereThereIsNone) { expect_silence(1000); }

// Above the edge the bins equal those of the same line without the figure.
TEST_WITH_SHORT_FORM(ShapeLeak, IsSaidAndWhatLiesAboveIsRight) {
  constexpr int kLines = 12;
  for (const ProfileQuantity quantity : {ProfileQuantity::kHeight, ProfileQuantity::kSlope})
    for (const double exponent : test::all_or_few(whole, std::vector{1.0, 2.0, 3.0}, {1}))
      for (const int degree : {1, 2})
        for (const int figure : {3, 4}) {
          if (!whole && figure != degree + 2) continue;
          PsdEstimatorOptions options;
          options.detrend.degree = degree;
          options.find_lines = false;
          const PsdEstimator estimator(random_line(falling(exponent), quantity, 0), options, 1);
          int warned = 0, begins_above = 0;
          double edge = 0, worst = 0;
          ArrayXd log_ratio, count;
          for (int i = 1; i <= kLines; ++i) {
            const Profile line = random_line(falling(exponent), quantity, i);
            const PsdEstimate clean = estimator(line), shaped = estimator(with_figure(line, figure, 100));
            warned += said(shaped);
            edge = std::max(edge, shaped.trusted_from);
            if (log_ratio.size() == 0) log_ratio = count = ArrayXd::Zero(clean.psd.size());
            const PsdModelFit fit = fit_psd_model(shaped);
            begins_above += fit.f_min >= shaped.trusted_from * (1 - 1e-9);
            for (Index b = 0; b < clean.psd.size(); ++b)
              if (shaped.frequency[b] >= std::max(shaped.trusted_from, 1.5 * clean.resolution))
                log_ratio[b] += std::log(shaped.psd[b] / clean.psd[b]), ++count[b];
          }
          const std::string where =
              fmt::format("f^-{} quantity {} degree {} figure {}", exponent, int(quantity), degree, figure);
          for (Index b = 0; b < count.size(); ++b)
            if (count[b] >= kLines / 4) worst = std::max(worst, std::abs(log_ratio[b] / count[b]));
          fmt::print("{}: warned {}, edge to {:.0f} /m, worst bin {:.2f}\n", where, warned, edge, worst);
          EXPECT_EQ(warned, kLines) << where;
          EXPECT_EQ(begins_above, kLines) << where;
          EXPECT_LT(worst, std::log(1.3)) << where;
        }
}

TEST(ShapeLeak, IsGoneWithTheShapeAndTakenInOnRequest) {
  const Profile line = with_figure(random_line(falling(2), ProfileQuantity::kHeight, 3), 4, 100);
  const PsdEstimate leaky = estimate_psd(line, {});
  ASSERT_TRUE(said(leaky));
  PsdFitOptions from;
  from.f_min = 3;
  EXPECT_LT(fit_psd_model(leaky, from).f_min, leaky.trusted_from);
  PsdEstimatorOptions options;
  options.detrend.degree = 4;
  EXPECT_FALSE(said(estimate_psd(line, options)));
}

TEST_WITH_SHORT_FORM(ShapeLeak, OfAMapIsSeenAndOfACleanOneIsNot) {
  for (int seed = 1; seed <= (whole ? 3 : 1); ++seed) {
    RandomSurfaceOptions draw;
    draw.seed = std::uint64_t(seed);
    draw.oversize = 4;
    HeightMap map =
        random_surface(RadialPsd(PowerLawPsd{std::nullopt, 1e-15, 3, 1, 500}), 128, 128, 1e-3, draw);
    EXPECT_FALSE(said(estimate_psd(map, {})));
    const double size = 300 * rms(detrend(map, {}));
    for (Index r = 0; r < 128; ++r)
      for (Index c = 0; c < 128; ++c) {
        const double x = double(c) / 63.5 - 1, y = double(r) / 63.5 - 1;
        map.height(r, c) += size * (2.5 * x * x * x - 1.5 * x + x * y * y);
      }
    const PsdEstimate shaped = estimate_psd(map, {});
    EXPECT_TRUE(said(shaped));
    EXPECT_GT(fit_psd_model(shaped).f_min, shaped.resolution * 2);
  }
}

}  // namespace
}  // namespace aberfit
