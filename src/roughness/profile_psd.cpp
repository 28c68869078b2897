#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/roughness/random_surface.h"
#include "profile_spectrum.h"

namespace aberfit {
using namespace internal;

namespace {

// int_h^inf S(g) g/sqrt(g^2 - f^2) dg if S is one power and h >= 2 f, by the binomial series of the root.
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

namespace internal {

ProfileSpectrum::ProfileSpectrum(const RadialPsd& psd, double lowest) : psd_(psd), tail_from_(psd.f_max()) {
  assert(lowest > 0);
  if (std::isinf(tail_from_)) {
    tail_ = psd.high_frequency_terms();
    tail_from_ = std::max(power_law_limits(psd).high, 2 * lowest);
  }
  panels_ = resolved_panels(psd, std::max(lowest, psd.f_min()), tail_from_);
}

double ProfileSpectrum::operator()(double f) const {
  assert(f > 0);
  if (f >= psd_.f_max()) return 0;
  if (!tail_.empty() && 2 * f > tail_from_) return ProfileSpectrum(psd_, f)(f);
  static const Quadrature rule = gauss_legendre(32, 0.0, 1.0);
  double sum = 0;
  for (const PowerTerm& term : tail_) sum += power_tail(term, f, tail_from_);
  const auto across = [f](double g) { return std::sqrt((g - f) * (g + f)); };
  auto panel =
      std::partition_point(panels_.begin(), panels_.end(), [f](const PsdPanel& p) { return p.b <= f; });
  // Near f we use u with g^2 = f^2 + u^2, so that S g/sqrt(g^2 - f^2) dg becomes the regular S du. Panels are
  // at most one octave wide, so from 2 f on the root is as smooth as S and the panel's nodes suffice.
  for (; panel != panels_.end() && panel->a < 2 * f; ++panel) {
    const double from = across(std::max(panel->a, f)), width = across(panel->b) - from;
    for (Eigen::Index j = 0; j < rule.nodes.size(); ++j) {
      const double g = std::hypot(f, from + width * rule.nodes[j]);
      sum += width * rule.weights[j] * psd_(std::min(g, psd_.f_max()));  // rounding must not leave the band
    }
  }
  for (; panel != panels_.end(); ++panel)
    sum += (panel->weight * panel->psd / (1 - (f / panel->f).square()).sqrt()).sum();
  return 4 * sum;
}

}  // namespace internal

double profile_psd(const RadialPsd& psd, double f) { return ProfileSpectrum(psd, f)(f); }

}  // namespace aberfit
