#include <cassert>
#include <cmath>
#include <limits>

#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/roughness/random_surface.h"

namespace aberfit {
namespace {

// int_h^inf S(g) g/sqrt(g^2 - f^2) dg where S is one power and h >= 2 f, by the binomial series of the root.
double power_tail(const PowerTerm& term, double f, double h) {
  const double p = term.exponent;
  if (p <= 1) return std::numeric_limits<double>::infinity();
  double sum = 0, root = 1;  // root: binomial(2k, k)/4^k (f/h)^2k
  for (int k = 0; root > 1e-17; ++k) {
    sum += root / (p - 1 + 2 * k);
    root *= (2 * k + 1) / (2.0 * k + 2) * (f / h) * (f / h);
  }
  return term(h) * h * sum;
}

}  // namespace

double profile_psd(const RadialPsd& psd, double f) {
  assert(f > 0);
  if (f >= psd.f_max()) return 0;
  // In u with f'^2 = f^2 + u^2 the integrand S(f') f'/sqrt(f'^2 - f^2) df' is S du: nothing singular at f.
  static const Quadrature rule = gauss_legendre(32, 0.0, 1.0);
  double top = psd.f_max(), sum = 0;
  if (std::isinf(top)) {
    top = std::max(power_law_limits(psd).high, 2 * f);
    for (const PowerTerm& term : psd.high_frequency_terms()) sum += power_tail(term, f, top);
  }
  const auto across = [f](double g) { return std::sqrt((g - f) * (g + f)); };
  for (const PsdPanel& panel : resolved_panels(psd, std::max(f, psd.f_min()), top)) {
    const double from = across(panel.a), width = across(panel.b) - from;
    for (Eigen::Index j = 0; j < rule.nodes.size(); ++j) {
      const double g = std::hypot(f, from + width * rule.nodes[j]);
      sum += width * rule.weights[j] * psd(std::min(g, psd.f_max()));  // rounding must not leave the band
    }
  }
  return 4 * sum;
}

}  // namespace aberfit
