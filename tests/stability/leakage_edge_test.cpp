// The windowed PSD of ever steeper spectra. From some exponent on, the side lobes of the window fill the
// bins. The truth is the power law of the simulated lines (random_line.h), with 1024 points and bins of 100
// to 300 frequency steps.
#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/spectrum/psd_estimate.h"
#include "edge.h"
#include "spectrum/random_line.h"

namespace aberfit::test {
namespace {

constexpr int kLines = 8;
// Promised error of the mean of 8 lines, in bins of at least 60 of the 200 ordinates. It covers chance (3 %),
// the smear of a window, and the leakage that needs no warning.
constexpr double kPromised = 0.3;

// Mean of the bins over truth, less 1, and whether most lines had a warning.
EdgeRow row_of(WindowKind window, double exponent) {
  PsdEstimatorOptions options;
  options.window = window, options.find_lines = false;
  const Spectrum spectrum = [=](double f) { return 1e-15 * std::pow(f, -exponent); };
  const PsdEstimator estimator(random_line(spectrum, ProfileQuantity::kHeight, 0), options, 1);
  double sum = 0;
  int bins = 0, told = 0;
  for (int line = 1; line <= kLines; ++line) {
    const PsdEstimate found = estimator(random_line(spectrum, ProfileQuantity::kHeight, line));
    for (Eigen::Index b = 0; b < found.psd.size(); ++b)
      if (found.frequency[b] > 100 && found.frequency[b] < 300)
        sum += found.psd[b] / spectrum(found.frequency[b]), ++bins;
    for (const Warning& warning : found.warnings) told += warning.code == "window-leaks";
  }
  return {exponent, std::abs(sum / bins - 1), kPromised, 2 * told > kLines};
}

Edge edge_of(WindowKind window, const std::vector<double>& exponents) {
  Edge edge("leakage_" + to_string(window), "exponent of the spectrum, window " + to_string(window) + " [1]",
            "bins over truth, less 1 [1]");
  edge.linear_parameter();
  for (const double exponent : exponents) edge.add(row_of(window, exponent));
  return edge;
}

TEST(StabilityEdge, LeakageWithoutAWindow) {
  Edge edge = edge_of(WindowKind::kNone, {0, 0.5, 1, 1.5, 2, 2.5, 3, 4, 5, 6});
  // The jump between the ends of a record of length T leaks as 1/(f T)^2; f = 177 /m, T = 1.024 m.
  edge.follows({"0.1 (2 f T)^(exponent - 2)",
                [](double exponent) { return 0.1 * std::pow(2 * 177 * 1.024, exponent - 2); }, 2.5, 6, 3});
  edge.expect();
}
TEST(StabilityEdge, LeakageOfHann) { edge_of(WindowKind::kHann, {0, 2, 3, 4, 5, 6, 7, 8}).expect(); }
TEST(StabilityEdge, LeakageOfHamming) { edge_of(WindowKind::kHamming, {0, 1, 2, 2.5, 3, 4, 6}).expect(); }
TEST(StabilityEdge, LeakageOfWelch) { edge_of(WindowKind::kWelch, {0, 2, 3, 4, 5, 6}).expect(); }
TEST(StabilityEdge, LeakageOfTukey) { edge_of(WindowKind::kTukey, {0, 2, 4, 5, 6, 8}).expect(); }
TEST(StabilityEdge, LeakageOfBlackmanHarris) {
  edge_of(WindowKind::kBlackmanHarris, {0, 2, 4, 5, 6, 8}).expect();
}

}  // namespace
}  // namespace aberfit::test
