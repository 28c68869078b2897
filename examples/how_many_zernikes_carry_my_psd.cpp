// How many Zernike terms does a roughness need? This program prints the fraction of its height variance over
// the aperture that the orders 2..n carry. Piston and tilt (n = 0, 1) do not widen the focus and are counted
// separately.
#include <fmt/format.h>

#include "aberfit/method/plan.h"
#include "aberfit/terms/modal_covariance.h"

int main() {
  const double radius = 0.2;  // of the aperture [m]
  const aberfit::RadialPsd psd(aberfit::UniformPsd{.rms = 100e-9, .f_min = 2.5, .f_max = 39.92});

  const double lost = aberfit::captured_fraction(psd, radius, 0, 1);
  fmt::print("piston and tilt hold {:.4f} % of the height variance\n", 100 * lost);
  for (const int n_max : {10, 20, 30, 40, 50})
    fmt::print("n_max {}: {:4} terms carry {:.4f} %\n", n_max, aberfit::zernike_modes(2, n_max).size(),
               100 * aberfit::captured_fraction(psd, radius, 2, n_max));

  const int enough = aberfit::order_to_carry(radius, psd.f_max());
  fmt::print("the whole band takes n_max {}: {} terms\n", enough, aberfit::zernike_modes(1, enough).size());
}
