#include <array>
#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/digamma.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <optional>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/psd.h"
#include "hankel_panels.h"
#include "psd_models.h"
#include "structure_quadrature.h"

namespace aberfit {
using namespace internal;

double internal::one_minus_jinc(double z) {
  if (z > 1) return 1 - 2 * boost::math::cyl_bessel_j(1, z) / z;
  const double q = 0.25 * z * z;
  double term = 0.5 * q, sum = term;
  for (int m = 2; std::abs(term) > 1e-17 * sum; ++m) {
    term *= -q / (m * (m + 1));
    sum += term;
  }
  return sum;
}

double internal::one_minus_matern(double nu, double a) {
  constexpr double kEvenExponent = 1e-9;  // distance of nu from an integer for the integer formula
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

Eigen::ArrayXd structure_function(const RadialPsd& psd, const Eigen::ArrayXd& r) {
  if (!has_finite_structure_function(psd)) return Eigen::ArrayXd::Constant(r.size(), kInfinity);
  Eigen::ArrayXd result = Eigen::ArrayXd::Zero(r.size());
  const double r_max = r.size() > 0 ? r.maxCoeff() : 0;
  if (r_max <= 0) return result;
  const double r_min = (r > 0).select(r, r_max).minCoeff();
  for (const RadialPsd::Part& part : psd.parts_) {
    const PsdPiece piece{part.factor, part.f_min, part.f_max};
    std::optional<StructureQuadrature> quadrature;  // made when first needed
    for (Eigen::Index i = 0; i < r.size(); ++i) {
      if (!(r[i] > 0)) continue;
      const std::optional<double> closed =
          std::visit([&](const auto& m) { return rules(m).structure(m, piece, r[i]); }, part.model);
      if (!closed && !quadrature) {
        RadialPsd alone;
        alone.parts_.push_back(part);
        alone.find_band();
        quadrature.emplace(
            alone, std::visit([&](const auto& m) { return rules(m).stretches(m, piece); }, part.model), r_min,
            r_max);
      }
      result[i] += closed ? *closed : (*quadrature)(r[i]);
    }
  }
  return result;
}

}  // namespace aberfit
