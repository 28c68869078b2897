#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/digamma.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <numbers>
#include <optional>

#include "aberfit/roughness/psd.h"
#include "aberfit/roughness/psd_integrals.h"
#include "hankel_panels.h"

namespace aberfit {
namespace {

using std::numbers::pi;

double square(double x) { return x * x; }

// 1 - J0(z) to rounding relative to itself.
double one_minus_j0(double z) {
  if (z > 1) return 1 - boost::math::cyl_bessel_j(0, z);
  const double q = 0.25 * z * z;
  double term = q, sum = q;
  for (int m = 2; std::abs(term) > 1e-17 * sum; ++m) {
    term *= -q / (m * m);
    sum += term;
  }
  return sum;
}

// 1 - 2 J1(z)/z, the same.
double one_minus_jinc(double z) {
  if (z > 1) return 1 - 2 * boost::math::cyl_bessel_j(1, z) / z;
  const double q = 0.25 * z * z;
  double term = 0.5 * q, sum = term;
  for (int m = 2; std::abs(term) > 1e-17 * sum; ++m) {
    term *= -q / (m * (m + 1));
    sum += term;
  }
  return sum;
}

constexpr double kEvenExponent = 1e-9;  // distance of nu from an integer below which its formula is used

// 1 - (2/Gamma(nu)) (a/2)^nu K_nu(a). Up to a = 2 from the series of K_nu without its first term:
// DLMF 10.27.4 with 10.25.2, and 10.31.1 for an integer nu.
double one_minus_matern(double nu, double a) {
  if (a > 700) return 1;
  if (a > 2)
    return 1 - 2 / boost::math::tgamma(nu) * std::pow(0.5 * a, nu) * boost::math::cyl_bessel_k(nu, a);
  const double q = 0.25 * a * a;
  const double nearest = std::round(nu);
  double sum = 0;
  if (std::abs(nu - nearest) < kEvenExponent && nearest >= 1) {
    const int n = int(nearest);
    double term = 1;  // (n-k-1)!/((n-1)! k!) (-q)^k
    for (int k = 1; k < n; ++k) {
      term *= -q / (k * double(n - k));
      sum -= term;
    }
    double power = (n % 2 == 0 ? 2 : -2) * std::exp(n * std::log(q) - std::lgamma(n) - std::lgamma(n + 1));
    double tail = 0;
    for (int k = 0; k < 30; ++k) {
      tail += power *
              (0.5 * (boost::math::digamma(k + 1.0) + boost::math::digamma(n + k + 1.0)) - 0.5 * std::log(q));
      power *= q / ((k + 1.0) * (n + k + 1.0));
    }
    return sum - tail;
  }
  double first = std::pow(q, nu) * boost::math::tgamma(1 - nu) / boost::math::tgamma(1 + nu), second = 1;
  sum = first;
  for (int k = 1; k < 200; ++k) {
    first *= q / (k * (k + nu));
    second *= q / (k * (k - nu));
    sum += first - second;
    if (std::abs(first) + std::abs(second) < 1e-18 * std::abs(sum) && k > nu) break;
  }
  return sum;
}

std::optional<double> closed_form(const GaussianPsd& m, double factor, double f_min, double f_max, double r) {
  if (f_min > 0 || std::isfinite(f_max)) return std::nullopt;
  return -factor / (pi * square(m.correlation_length)) * std::expm1(-square(r / m.correlation_length));
}

std::optional<double> closed_form(const KCorrelationPsd& m, double factor, double f_min, double f_max,
                                  double r) {
  const double nu = 0.5 * m.exponent - 1;
  if (f_min > 0 || std::isfinite(f_max) || nu > 60) return std::nullopt;  // beyond, K_nu overflows
  return pi * factor / (square(m.correlation) * nu) * one_minus_matern(nu, 2 * pi * r / m.correlation);
}

std::optional<double> closed_form(const UniformPsd&, double factor, double f_min, double f_max, double r) {
  if (f_max - f_min < 0.1 * f_max) return std::nullopt;  // the difference of the discs would lose digits
  const auto disc = [r](double f) { return pi * f * f * one_minus_jinc(2 * pi * r * f); };
  return factor * (disc(f_max) - disc(f_min));
}

template <class Model>
std::optional<double> closed_form(const Model&, double, double, double, double) {
  return std::nullopt;
}

// int S (1 - J0(2 pi f r)) d2f of any S with a finite height variance, panel by panel.
class ByQuadrature {
 public:
  ByQuadrature(const RadialPsd& psd, double r_min, double r_max) : shared_(shared_panels(psd, r_min, r_max)) {
    for (const PsdPanel& panel : shared_.panels) {
      Powers& powers = powers_.emplace_back();
      PanelArray term = 2 * pi * panel.weight * panel.psd * panel.f;
      for (double& power : powers) {
        power = term.sum();
        term *= (pi * panel.f).square();
      }
    }
    if (std::isinf(psd.f_max()) && !shared_.panels.empty())
      beyond_ = radial_moment(psd, 0, shared_.panels.back().b);  // where J0 has averaged out
  }

  double operator()(double r) const {
    const double k = 2 * pi * r;
    double sum = beyond_;
    for (std::size_t i = 0; i < shared_.panels.size(); ++i) {
      const PsdPanel& panel = shared_.panels[i];
      const Powers& p = powers_[i];
      if (k * panel.b < 0.2) {  // four terms of 1 - J0: the next is 1e-12 of the first
        const double q = r * r;
        sum += q * (p[1] - q / 4 * (p[2] - q / 9 * (p[3] - q / 16 * p[4])));
      } else if (k * panel.a <
                 kHankelFrom) {  // an octave: 24 nodes resolve 30 rad of J0 (see autocorrelation)
        for (int j = 0; j < kPanelNodes; ++j)
          sum += 2 * pi * panel.weight[j] * panel.psd[j] * panel.f[j] * one_minus_j0(k * panel.f[j]);
      } else {
        const auto weights = oscillatory_weights(panel.a, panel.b, k);
        std::complex<double> total = 0;
        for (int j = 0; j < kPanelNodes; ++j) {
          const double x = k * panel.f[j];
          total +=
              weights[j] * hankel_amplitudes(x).h0 * (panel.psd[j] * panel.f[j] * std::sqrt(2 / (pi * x)));
        }
        sum += p[0] - 2 * pi * (total * std::polar(1.0, -0.25 * pi)).real();
      }
    }
    return sum;
  }

 private:
  using Powers = std::array<double, 5>;  // int S (pi f)^(2 m) d2f over a panel
  SharedPanels shared_;
  std::vector<Powers> powers_;
  double beyond_ = 0;
};

}  // namespace

Eigen::ArrayXd structure_function(const RadialPsd& psd, const Eigen::ArrayXd& r) {
  if (!has_finite_height_variance(psd))
    return Eigen::ArrayXd::Constant(r.size(), std::numeric_limits<double>::infinity());
  Eigen::ArrayXd result = Eigen::ArrayXd::Zero(r.size());
  const double r_max = r.size() > 0 ? r.maxCoeff() : 0;
  if (r_max <= 0) return result;
  const double r_min = (r > 0).select(r, r_max).minCoeff();
  for (const RadialPsd::Part& part : psd.parts_) {
    std::optional<ByQuadrature> quadrature;  // made when the first r without a closed form comes
    for (Eigen::Index i = 0; i < r.size(); ++i) {
      if (!(r[i] > 0)) continue;
      const std::optional<double> closed =
          std::visit([&](const auto& m) { return closed_form(m, part.factor, part.f_min, part.f_max, r[i]); },
                     part.model);
      if (!closed && !quadrature) {
        RadialPsd alone;
        alone.parts_.push_back(part);
        alone.find_band();
        quadrature.emplace(alone, r_min, r_max);
      }
      result[i] += closed ? *closed : (*quadrature)(r[i]);
    }
  }
  return result;
}

}  // namespace aberfit
