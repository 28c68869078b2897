// Tests the end of an instrument's transfer function with random profiles and maps: some are filtered above a
// frequency and have white noise there, others are not filtered.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "aberfit/core/parallel.h"
#include "aberfit/spectrum/psd_model_fit.h"
#include "short_form.h"
#include "spectrum/random_line.h"

namespace aberfit {
namespace {

using test::random_line;
using test::Spectrum;

const double kBin = std::pow(10, 1.0 / 12);

std::vector<double> edges(const Spectrum& spectrum, ProfileQuantity quantity, int profiles) {
  const PsdEstimator estimator(random_line(spectrum, quantity, 0), {}, 1);
  std::vector<double> found(static_cast<std::size_t>(profiles));
  parallel_for(found.size(), 2, [&](std::size_t i) {
    const PsdEstimate estimate = estimator(random_line(spectrum, quantity, int(i) + 1));
    found[i] = estimate.trusted_to;
    bool said = false;
    for (const Warning& warning : estimate.warnings) said = said || warning.code == "instrument-cut-off";
    EXPECT_EQ(std::isfinite(estimate.trusted_to), said);
  });
  return found;
}

TEST_WITH_SHORT_FORM(InstrumentEdge, IsFoundWithinABinWhereAFilterEnds) {
  const int profiles = whole ? 100 : 20;
  for (const ProfileQuantity quantity : {ProfileQuantity::kHeight, ProfileQuantity::kSlope})
    for (const double exponent : {2.0, 3.0, 4.0})
      for (const double share : {0.4, 0.7}) {
        const double cut = share * 0.5 / test::kLinePitch, left = 3e-3 * std::pow(cut, -exponent);
        const auto filtered = [=](double f) { return 1e-15 * (f < cut ? std::pow(f, -exponent) : left); };
        int within = 0;
        for (const double edge : edges(filtered, quantity, profiles))
          within += std::abs(std::log(edge / cut)) < std::log(kBin);
        const std::string where =
            fmt::format("f^-{} to {} of Nyquist, quantity {}", exponent, share, int(quantity));
        fmt::print("{}: {} of {}\n", where, within, profiles);
        EXPECT_GE(within, 0.95 * profiles) << where;
      }
}

TEST_WITH_SHORT_FORM(InstrumentEdge, IsNotSeenWhereThereIsNone) {
  const Spectrum clean[] = {
      [](double f) { return 1e-15 * std::pow(f, -2); }, [](double f) { return 1e-15 * std::pow(f, -4); },
      [](double f) { return 1e-18 * std::pow(1 + 0.0025 * f * f, -2); },        // knee at 20/m, f^-4 beyond
      [](double f) { return 1e-15 * std::pow(f, -3) + 1e-21; },                 // floor
      [](double f) { return 1e-18 * (f > 40 && f < 60 ? 20 : 1) / (1 + f); }};  // a band that polishing left
  int seen = 0, looks = 0;
  for (const ProfileQuantity quantity : {ProfileQuantity::kHeight, ProfileQuantity::kSlope})
    for (const Spectrum& spectrum : clean) {
      const int before = seen;
      for (const double edge : edges(spectrum, quantity, whole ? 100 : 40))
        seen += std::isfinite(edge), ++looks;
      EXPECT_LE(seen - before, 2) << &spectrum - clean;
    }
  fmt::print("{} of {}\n", seen, looks);
  EXPECT_LT(seen, 0.01 * looks);
}

// The fit ends at the edge unless f_max is larger.
TEST(InstrumentEdge, EndsTheFitUnlessFMaxGoesBeyond) {
  const auto filtered = [](double f) { return 1e-15 * (f < 200 ? std::pow(f, -3) : 1e-10); };
  const PsdEstimate estimate = estimate_psd(random_line(filtered, ProfileQuantity::kHeight, 7), {});
  PsdFitOptions options;
  options.family = PsdFamily::kPowerLaw;
  const PsdModelFit fit = fit_psd_model(estimate, options);
  EXPECT_NEAR(fit.f_max, estimate.trusted_to, 1e-9 * fit.f_max);
  EXPECT_LT(fit.parameters.at(1).lower, 4);
  EXPECT_GT(fit.parameters.at(1).upper, 4);
  options.f_max = 490;
  EXPECT_GT(fit_psd_model(estimate, options).f_max, 400);
}

}  // namespace
}  // namespace aberfit
