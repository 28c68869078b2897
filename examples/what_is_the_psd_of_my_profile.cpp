// What is the PSD of my profile? Here the profile is a realisation of a known surface, so that the answer can
// be judged. read_measurement (aberfit/measured/read_measurement.h) reads a profile from a file.
#include <fmt/format.h>

#include "aberfit/roughness/random_surface.h"
#include "aberfit/spectrum/psd_model_fit.h"

int main() {
  const aberfit::KCorrelationPsd truth{.rms = 5e-9, .correlation = 8e-3, .exponent = 4};
  const aberfit::Profile profile =
      aberfit::random_profile(aberfit::RadialPsd(truth), 1000, 0.2e-3, {.seed = 3});

  const aberfit::PsdEstimate estimate = aberfit::estimate_psd(profile, {});
  fmt::print("RMS height {:.2f} nm after a quadratic is removed, {} bins from {:.0f} to {:.0f} cycles/m\n",
             1e9 * estimate.rms_height, estimate.psd.size(), estimate.low[0],
             estimate.high[estimate.high.size() - 1]);

  const aberfit::PsdModelFit fit = aberfit::fit_psd_model(estimate);
  fmt::print("model: {}\n", to_string(fit.family));
  for (const aberfit::PsdParameter& p : fit.parameters) {
    const double true_value = p.name == "B" ? truth.correlation : p.name == "exponent" ? truth.exponent : 0;
    if (true_value > 0)
      fmt::print("{} = {:.3g} [{}], 95 % interval {:.3g} .. {:.3g}: the true {:.3g} is {}\n", p.name, p.value,
                 p.unit, p.lower, p.upper, true_value,
                 true_value > p.lower && true_value < p.upper ? "inside" : "outside");
  }
}
