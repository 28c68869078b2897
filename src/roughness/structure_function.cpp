#include <array>
#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/digamma.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <optional>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/psd.h"
#include "hankel_panels.h"
#include "square.h"
#include "structure_quadrature.h"

namespace aberfit {
using namespace internal;

namespace {

// 1 - 2 J1(z)/z with a relative error of rounding.
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

constexpr double kEvenExponent = 1e-9;  // distance of nu from an integer for the integer formula

// 1 - (2/Gamma(nu)) (a/2)^nu K_nu(a). Up to a = 2 it uses the series of K_nu without its first term: DLMF
// 10.27.4 with 10.25.2, and 10.31.1 for an integer nu.
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
    double power = (n % 2 == 0 ? 2 : -2) *
                   std::exp(n * std::log(q) - boost::math::lgamma(n) - boost::math::lgamma(n + 1));
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

std::optional<double> structure_closed_form(const GaussianPsd& m, double factor, double f_min, double f_max,
                                            double r) {
  if (f_min > 0 || std::isfinite(f_max)) return std::nullopt;
  return -factor / (kPi * square(m.correlation_length)) * std::expm1(-square(r / m.correlation_length));
}

std::optional<double> structure_closed_form(const KCorrelationPsd& m, double factor, double f_min,
                                            double f_max, double r) {
  const double nu = 0.5 * m.exponent - 1;
  if (f_min > 0 || std::isfinite(f_max) || nu > 60) return std::nullopt;  // K_nu overflows for larger nu
  return kPi * factor / (square(m.correlation) * nu) * one_minus_matern(nu, 2 * kPi * r / m.correlation);
}

std::optional<double> structure_closed_form(const UniformPsd&, double factor, double f_min, double f_max,
                                            double r) {
  if (f_max - f_min < 0.1 * f_max) return std::nullopt;  // the difference of the discs would lose digits
  const auto disc = [r](double f) { return kPi * f * f * one_minus_jinc(2 * kPi * r * f); };
  return factor * (disc(f_max) - disc(f_min));
}

template <class Model>
std::optional<double> structure_closed_form(const Model&, double, double, double, double) {
  return std::nullopt;
}

std::vector<PowerStretch> power_stretches(const PowerLawPsd& m, double f_min, double f_max) {
  return {PowerStretch(f_min, f_max, m.exponent)};
}
std::vector<PowerStretch> power_stretches(const UniformPsd&, double f_min, double f_max) {
  return {PowerStretch(f_min, f_max, 0)};
}
std::vector<PowerStretch> power_stretches(const TablePsd& m, double f_min, double f_max) {
  std::vector<PowerStretch> stretches;
  for (std::size_t i = 0; i + 1 < m.frequency.size(); ++i) {
    const double a = m.frequency[i], b = m.frequency[i + 1];
    if (a < f_max && b > f_min)
      stretches.emplace_back(std::max(a, f_min), std::min(b, f_max),
                             -std::log(m.psd[i + 1] / m.psd[i]) / std::log(b / a));
  }
  return stretches;
}
template <class Model>
std::vector<PowerStretch> power_stretches(const Model&, double, double) {
  return {};
}

}  // namespace

Eigen::ArrayXd structure_function(const RadialPsd& psd, const Eigen::ArrayXd& r) {
  if (!has_finite_structure_function(psd)) return Eigen::ArrayXd::Constant(r.size(), kInfinity);
  Eigen::ArrayXd result = Eigen::ArrayXd::Zero(r.size());
  const double r_max = r.size() > 0 ? r.maxCoeff() : 0;
  if (r_max <= 0) return result;
  const double r_min = (r > 0).select(r, r_max).minCoeff();
  for (const RadialPsd::Part& part : psd.parts_) {
    std::optional<StructureQuadrature> quadrature;  // made when first needed
    for (Eigen::Index i = 0; i < r.size(); ++i) {
      if (!(r[i] > 0)) continue;
      const std::optional<double> closed = std::visit(
          [&](const auto& m) { return structure_closed_form(m, part.factor, part.f_min, part.f_max, r[i]); },
          part.model);
      if (!closed && !quadrature) {
        RadialPsd alone;
        alone.parts_.push_back(part);
        alone.find_band();
        quadrature.emplace(
            alone,
            std::visit([&](const auto& m) { return power_stretches(m, part.f_min, part.f_max); }, part.model),
            r_min, r_max);
      }
      result[i] += closed ? *closed : (*quadrature)(r[i]);
    }
  }
  return result;
}

}  // namespace aberfit
