#include "even_polynomial.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "pupil_kernel.h"

namespace aberfit::internal {
namespace {

constexpr int kMostDegree = 24, kLooksPerPoint = 3;

// Coefficients of the polynomial in t through `values` at the Chebyshev points cos((k + 1/2) pi/n).
std::vector<double> powers_through(const Eigen::ArrayXd& values) {
  const auto n = int(values.size());
  std::vector<double> sum(std::size_t(n), 0.0), before(sum), last(sum);  // T_(j-2), T_(j-1) as powers
  for (int j = 0; j < n; ++j) {
    double share = 0;
    for (int k = 0; k < n; ++k) share += values[k] * std::cos(j * (k + 0.5) * kPi / n);
    share *= (j == 0 ? 1.0 : 2.0) / n;
    std::vector<double> now(std::size_t(n), 0.0);
    if (j == 0) {
      now[0] = 1;
    } else if (j == 1) {
      now[1] = 1;
    } else {
      for (int i = 0; i + 1 < n; ++i) now[std::size_t(i) + 1] = 2 * last[std::size_t(i)];
      for (int i = 0; i < n; ++i) now[std::size_t(i)] -= before[std::size_t(i)];
    }
    for (int i = 0; i < n; ++i) sum[std::size_t(i)] += share * now[std::size_t(i)];
    before = last;
    last = now;
  }
  return sum;
}

}  // namespace

std::optional<EvenPolynomial> EvenPolynomial::of(const std::function<double(double)>& function, double radius,
                                                 double error) {
  const auto at = [&](double t) { return function(radius * std::sqrt(std::max(0.0, 0.5 * (t + 1)))); };
  for (int degree = 2; degree <= kMostDegree; degree += 2) {
    EvenPolynomial found;
    found.scale_ = 2 / (radius * radius);
    Eigen::ArrayXd values(degree + 1);
    for (int k = 0; k <= degree; ++k) values[k] = at(std::cos((k + 0.5) * kPi / (degree + 1)));
    if (!values.allFinite()) return std::nullopt;
    found.coefficient_ = powers_through(values);
    const int looks = kLooksPerPoint * (degree + 1);
    double worst = 0;
    for (int k = 0; k <= looks; ++k) {
      const double t = std::cos(k * kPi / looks);
      const double off = std::abs(found.value(0.5 * (t + 1) * radius * radius) - at(t));
      worst = off <= worst ? worst : off;  // keeps NaN
    }
    if (worst <= error) return found;
  }
  return std::nullopt;
}

double EvenPolynomial::value(double square) const {
  const double t = scale_ * square - 1;
  double sum = 0;
  for (std::size_t j = coefficient_.size(); j-- > 0;) sum = sum * t + coefficient_[j];
  return sum;
}

void EvenPolynomial::add(const double* x, const double* y, int n, double* result, InstructionSet set) const {
  add_even_polynomial(set, coefficient_.data(), degree(), scale_, x, y, n, result);
}

}  // namespace aberfit::internal
