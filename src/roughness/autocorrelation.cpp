#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <numbers>
#include <optional>

#include "aberfit/roughness/psd.h"
#include "aberfit/roughness/psd_integrals.h"

namespace aberfit {
namespace {

using std::numbers::pi;
constexpr double kHankelFrom = 30;  // argument of J0 beyond which its Hankel amplitude is exact to rounding

double square(double x) { return x * x; }

// C(r) = sigma^2 exp(-(r/l)^2).
std::optional<double> closed_form(const GaussianPsd& m, double factor, double f_min, double f_max, double r) {
  if (f_min > 0 || std::isfinite(f_max)) return std::nullopt;
  return factor / (pi * square(m.correlation_length)) * std::exp(-square(r / m.correlation_length));
}

// C(r) = 2 pi A / B^2 (a/2)^nu K_nu(a) / Gamma(nu + 1), a = 2 pi r / B, nu = c/2 - 1 (Hankel transform of (1 + x^2)^(-nu-1), DLMF 10.22.46).
std::optional<double> closed_form(const KCorrelationPsd& m, double factor, double f_min, double f_max, double r) {
  const double nu = 0.5 * m.exponent - 1, a = 2 * pi * r / m.correlation;
  if (f_min > 0 || std::isfinite(f_max)) return std::nullopt;
  const double scale = pi * factor / square(m.correlation);
  if (a < 1e-200 || nu * std::log(2 / a) + std::lgamma(nu + 1) > 600) return std::nullopt;  // K_nu would overflow
  if (a > 700) return 0.0;
  return 2 * scale * std::pow(0.5 * a, nu) * boost::math::cyl_bessel_k(nu, a) / std::tgamma(nu + 1);
}

// C(r) = S [f J1(2 pi r f)/r] between the band edges; the difference of narrow bands loses digits.
std::optional<double> closed_form(const UniformPsd&, double factor, double f_min, double f_max, double r) {
  if (f_max - f_min < 0.1 * f_max) return std::nullopt;
  const auto disc = [r](double f) {
    const double x = 2 * pi * r * f;
    return x < 1e-9 ? pi * f * f : f * boost::math::cyl_bessel_j(1, x) / r;
  };
  return factor * (disc(f_max) - disc(f_min));
}

template <class Model>
std::optional<double> closed_form(const Model&, double, double, double, double) {
  return std::nullopt;
}

// Any S with a finite height variance; r > 0.
double by_quadrature(const RadialPsd& psd, double r) {
  const double k = 2 * pi * r, turn = kHankelFrom / k;
  const PowerLawLimits limits = power_law_limits(psd);
  // Below `low` also J0 = 1 to rounding; above `high` the oscillation has averaged S away, or S is gone.
  const double low = psd.f_min() > 0 ? psd.f_min() : std::min(limits.low, 1e-9 / k);
  double high = limits.high;
  if (std::isinf(psd.f_max())) high = std::max(high, 1e9 * turn);
  double sum = psd.f_min() > 0 ? 0 : radial_moment(psd, 0, 0, low);
  for (const PsdPanel& panel : resolved_panels(psd, low, std::min(high, turn)))
    for (int j = 0; j < kPanelNodes; ++j)
      sum += 2 * pi * panel.weight[j] * panel.psd[j] * panel.f[j] * boost::math::cyl_bessel_j(0, k * panel.f[j]);
  for (const PsdPanel& panel : resolved_panels(psd, std::max(low, turn), high)) {
    const auto weights = oscillatory_weights(panel.a, panel.b, k);
    std::complex<double> total = 0;
    for (int j = 0; j < kPanelNodes; ++j) {
      const double x = k * panel.f[j];
      total += weights[j] * hankel_amplitudes(x).h0 * (panel.psd[j] * panel.f[j] * std::sqrt(2 / (pi * x)));
    }
    sum += 2 * pi * (total * std::polar(1.0, -0.25 * pi)).real();
  }
  return sum;
}

}  // namespace

double autocorrelation(const RadialPsd& psd, double r) {
  const double height_variance = radial_moment(psd, 0);
  if (r <= 0 || !std::isfinite(height_variance)) return height_variance;
  double sum = 0;
  for (const RadialPsd::Part& part : psd.parts_) {
    const std::optional<double> closed = std::visit(
        [&](const auto& m) { return closed_form(m, part.factor, part.f_min, part.f_max, r); }, part.model);
    if (closed) {
      sum += *closed;
      continue;
    }
    RadialPsd alone;
    alone.parts_.push_back(part);
    alone.find_band();
    sum += by_quadrature(alone, r);
  }
  return sum;
}

}  // namespace aberfit
