#include "aberfit/core/quadrature.h"

#include <boost/math/special_functions/legendre.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace aberfit {
namespace {

// The non-negative zeros of a Legendre polynomial, ascending, and its derivative there.
struct LegendreZeros {
  std::vector<double> zeros, derivatives;
};

// Thousands of rules differ only in their ends. Without this cache the zeros would take two thirds of the
// time of the theory. Few orders are in use; the first ones are kept.
std::shared_ptr<const LegendreZeros> legendre_zeros(int n) {
  constexpr std::size_t kMostKept = 200;
  static std::mutex mutex;
  static std::map<int, std::shared_ptr<const LegendreZeros>> kept;
  {
    const std::lock_guard lock(mutex);
    if (const auto known = kept.find(n); known != kept.end()) return known->second;
  }
  auto found = std::make_shared<LegendreZeros>();
  found->zeros = boost::math::legendre_p_zeros<double>(n);
  for (const double x : found->zeros) found->derivatives.push_back(boost::math::legendre_p_prime(n, x));
  const std::lock_guard lock(mutex);
  if (kept.size() < kMostKept) kept.emplace(n, found);
  return found;
}

}  // namespace

Quadrature gauss_legendre(int n, double a, double b) {
  const std::shared_ptr<const LegendreZeros> polynomial = legendre_zeros(n);
  const std::vector<double>& zeros = polynomial->zeros;
  Quadrature rule{Eigen::ArrayXd(n), Eigen::ArrayXd(n)};
  const double centre = 0.5 * (a + b), half = 0.5 * (b - a);
  for (std::size_t i = 0; i < zeros.size(); ++i) {
    const double x = zeros[i], derivative = polynomial->derivatives[i];
    const double weight = half * 2.0 / ((1.0 - x * x) * derivative * derivative);
    const Eigen::Index upper = n / 2 + Eigen::Index(i), lower = n - 1 - upper;
    rule.nodes[upper] = centre + half * x;
    rule.nodes[lower] = centre - half * x;
    rule.weights[upper] = rule.weights[lower] = weight;
  }
  return rule;
}

Eigen::ArrayXXd legendre_polynomials(const Eigen::ArrayXd& t, int count) {
  Eigen::ArrayXXd p = Eigen::ArrayXXd::Ones(t.size(), count);
  if (count > 1) p.col(1) = t;
  for (int l = 1; l + 1 < count; ++l)
    p.col(l + 1) = ((2 * l + 1) * t * p.col(l) - l * p.col(l - 1)) / (l + 1.0);
  return p;
}

LegendreRule legendre_rule(int n) {
  const Quadrature rule = gauss_legendre(n, -1.0, 1.0);
  return {rule.nodes, rule.weights, legendre_polynomials(rule.nodes, n)};
}

}  // namespace aberfit
