#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <optional>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/roughness/psd_integrals.h"
#include "hankel_panels.h"
#include "square.h"

namespace aberfit {
using namespace internal;

namespace {

// C(r) = sigma^2 exp(-(r/l)^2).
std::optional<double> autocorrelation_closed_form(const GaussianPsd& m, double factor, double f_min,
                                                  double f_max, double r) {
  if (f_min > 0 || std::isfinite(f_max)) return std::nullopt;
  return factor / (kPi * square(m.correlation_length)) * std::exp(-square(r / m.correlation_length));
}

// C(r) = 2 pi A / B^2 (a/2)^nu K_nu(a) / Gamma(nu + 1), a = 2 pi r / B, nu = c/2 - 1 (Hankel transform of (1
// + x^2)^(-nu-1), DLMF 10.22.46).
std::optional<double> autocorrelation_closed_form(const KCorrelationPsd& m, double factor, double f_min,
                                                  double f_max, double r) {
  const double nu = 0.5 * m.exponent - 1, a = 2 * kPi * r / m.correlation;
  if (f_min > 0 || std::isfinite(f_max)) return std::nullopt;
  const double scale = kPi * factor / square(m.correlation);
  if (a < 1e-200 || nu * std::log(2 / a) + boost::math::lgamma(nu + 1) > 600)
    return std::nullopt;  // K_nu would overflow
  if (a > 700) return 0.0;
  return 2 * scale * std::pow(0.5 * a, nu) * boost::math::cyl_bessel_k(nu, a) / std::tgamma(nu + 1);
}

// C(r) = S [f J1(2 pi r f)/r] between the band edges. For narrow bands the difference loses digits.
std::optional<double> autocorrelation_closed_form(const UniformPsd&, double factor, double f_min,
                                                  double f_max, double r) {
  if (f_max - f_min < 0.1 * f_max) return std::nullopt;
  const auto disc = [r](double f) {
    const double x = 2 * kPi * r * f;
    return x < 1e-9 ? kPi * f * f : f * boost::math::cyl_bessel_j(1, x) / r;
  };
  return factor * (disc(f_max) - disc(f_min));
}

template <class Model>
std::optional<double> autocorrelation_closed_form(const Model&, double, double, double, double) {
  return std::nullopt;
}

// Any S with a finite height variance; r > 0.
double by_quadrature(const SharedPanels& shared, double r) {
  const double k = 2 * kPi * r;
  double sum = shared.low_variance;
  for (const PsdPanel& panel : shared.panels) {
    if (k * panel.a <
        // One octave: the argument of J0 spans 30 rad at most, and 24 nodes resolve it to 1e-19 (j_48(15)).
        kHankelFrom) {
      for (int j = 0; j < kPanelNodes; ++j)
        sum += 2 * kPi * panel.weight[j] * panel.psd[j] * panel.f[j] *
               boost::math::cyl_bessel_j(0, k * panel.f[j]);
      continue;
    }
    const auto weights = oscillatory_weights(panel.a, panel.b, k);
    std::complex<double> total = 0;
    for (int j = 0; j < kPanelNodes; ++j) {
      const double x = k * panel.f[j];
      total += weights[j] * hankel_amplitudes(x).h0 * (panel.psd[j] * panel.f[j] * std::sqrt(2 / (kPi * x)));
    }
    sum += 2 * kPi * (total * std::polar(1.0, -0.25 * kPi)).real();
  }
  return sum;
}

}  // namespace

Eigen::ArrayXd autocorrelation(const RadialPsd& psd, const Eigen::ArrayXd& r) {
  if (!has_finite_height_variance(psd)) return Eigen::ArrayXd::Constant(r.size(), kInfinity);
  Eigen::ArrayXd result = Eigen::ArrayXd::Zero(r.size());
  if ((r <= 0).any()) result = (r <= 0).select(radial_moment(psd, 0), result);
  const Eigen::ArrayXd positive = (r > 0).select(r, kInfinity);
  const double r_max = r.size() > 0 ? r.maxCoeff() : 0;
  if (r_max <= 0) return result;
  for (const RadialPsd::Part& part : psd.parts_) {
    std::optional<SharedPanels> shared;  // made when first needed
    for (Eigen::Index i = 0; i < r.size(); ++i) {
      if (!(r[i] > 0)) continue;
      const std::optional<double> closed = std::visit(
          [&](const auto& m) {
            return autocorrelation_closed_form(m, part.factor, part.f_min, part.f_max, r[i]);
          },
          part.model);
      if (!closed && !shared) {
        RadialPsd alone;
        alone.parts_.push_back(part);
        alone.find_band();
        shared = shared_panels(alone, positive.minCoeff(), r_max);
      }
      result[i] += closed ? *closed : by_quadrature(*shared, r[i]);
    }
  }
  return result;
}

double autocorrelation(const RadialPsd& psd, double r) {
  return autocorrelation(psd, Eigen::ArrayXd::Constant(1, r))[0];
}

}  // namespace aberfit
