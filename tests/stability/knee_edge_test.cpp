// A k-correlation whose knee leaves the band of the bins. The truth is the spectrum of the simulated lines
// (random_line.h); the bins cover 1.5 to 500 cycles/m.
#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/spectrum/psd_model_fit.h"
#include "edge.h"
#include "spectrum/random_line.h"

namespace aberfit::test {
namespace {

TEST(StabilityEdge, KneeOutsideTheBand) {
  Edge edge("knee_outside_the_band", "frequency of the knee, band 1.5 .. 500 /m [1/m]",
            "relative error of B [1]");
  for (const double knee : geometric_steps(0.05, 2e4, 18)) {
    const Spectrum spectrum = [=](double f) { return 1e-18 * std::pow(1 + std::pow(f / knee, 2), -1.25); };
    const PsdEstimate estimate = estimate_psd(random_line(spectrum, ProfileQuantity::kHeight, 3), {});
    PsdFitOptions options;
    options.family = PsdFamily::kKCorrelation;
    const PsdModelFit fit = fit_psd_model(estimate, options);
    EdgeRow row{knee, std::nan(""), 0, false};
    for (const Warning& warning : fit.warnings) row.told = row.told || warning.code == "not-identified";
    for (const PsdParameter& p : fit.parameters) {
      if (p.name != "B" || !p.identified) continue;
      row.error = std::abs(p.value * knee - 1);
      row.promised = 4 * p.std / p.value;  // Wald's interval at 6e-5
    }
    edge.add(row);
  }
  edge.expect();
}

}  // namespace
}  // namespace aberfit::test
