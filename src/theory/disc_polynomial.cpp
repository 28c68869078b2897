#include "disc_polynomial.h"

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "aberfit/core/linear_algebra.h"

#define ABERFIT_KERNEL_BODY "../theory/disc_polynomial_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit::internal {
namespace {

constexpr int kHighestDegree = 16;

struct DiscPoints {
  Eigen::ArrayXd x, y;
};
// Rings that are dense at the rim, where polynomials turn fastest, each with as many points as tell the
// degree's azimuthal orders apart. part in [0, 1): of the way to the next ring; points of two parts lie at
// directions that have no common measure, so that no order looks the same in both.
DiscPoints rings_of(int degree, double radius, double part) {
  const int rings = degree + 2, spokes = 2 * degree + 5;
  DiscPoints points{Eigen::ArrayXd(rings * spokes), Eigen::ArrayXd(rings * spokes)};
  for (int k = 0; k < rings; ++k)
    for (int s = 0; s < spokes; ++s) {
      const double r = radius * std::sin(0.5 * std::numbers::pi * (k + 1 - part) / rings),
                   angle = 2 * std::numbers::pi * (s + std::numbers::phi * part + 0.5 * (k % 2)) / spokes;
      points.x[k * spokes + s] = r * std::cos(angle);
      points.y[k * spokes + s] = r * std::sin(angle);
    }
  return points;
}

Eigen::ArrayXd values_at(const DiscPoints& points, const std::function<double(double, double)>& function) {
  Eigen::ArrayXd values(points.x.size());
  for (Eigen::Index k = 0; k < values.size(); ++k) values[k] = function(points.x[k], points.y[k]);
  return values;
}

// Column i: T_i at the points.
Eigen::ArrayXXd chebyshev(const Eigen::ArrayXd& t, int degree) {
  Eigen::ArrayXXd values(t.size(), degree + 1);
  values.col(0).setOnes();
  if (degree > 0) values.col(1) = t;
  for (int i = 2; i <= degree; ++i) values.col(i) = 2 * t * values.col(i - 1) - values.col(i - 2);
  return values;
}

// (i, p): coefficient of t^p in T_i.
Eigen::MatrixXd powers_of_chebyshev(int degree) {
  Eigen::MatrixXd powers = Eigen::MatrixXd::Zero(degree + 1, degree + 1);
  powers(0, 0) = 1;
  if (degree > 0) powers(1, 1) = 1;
  for (int i = 2; i <= degree; ++i) {
    powers.row(i).tail(degree) = 2 * powers.row(i - 1).head(degree);
    powers.row(i) -= powers.row(i - 2);
  }
  return powers;
}

// (i, j): of T_i(x / radius) T_j(y / radius), i + j <= degree, least squares.
Eigen::MatrixXd fitted(const DiscPoints& points, const Eigen::ArrayXd& values, double radius, int degree) {
  const Eigen::ArrayXXd in_x = chebyshev(points.x / radius, degree),
                        in_y = chebyshev(points.y / radius, degree);
  Eigen::MatrixXd design(values.size(), (degree + 1) * (degree + 2) / 2);
  Eigen::Index column = 0;
  for (int j = 0; j <= degree; ++j)
    for (int i = 0; i + j <= degree; ++i) design.col(column++) = in_x.col(i) * in_y.col(j);
  const Eigen::VectorXd solution = LeastNorm(design).solve(Eigen::VectorXd(values));
  Eigen::MatrixXd coefficient = Eigen::MatrixXd::Zero(degree + 1, degree + 1);
  column = 0;
  for (int j = 0; j <= degree; ++j)
    for (int i = 0; i + j <= degree; ++i) coefficient(i, j) = solution[column++];
  return coefficient;
}

}  // namespace

std::optional<DiscPolynomial> DiscPolynomial::of(const std::function<double(double, double)>& function,
                                                 double radius, double error) {
  for (int degree = 4; degree <= kHighestDegree; degree += 2) {
    const DiscPoints points = rings_of(degree, radius, 0), between = rings_of(degree, radius, 0.5);
    const Eigen::ArrayXd values = values_at(points, function), others = values_at(between, function);
    if (!values.isFinite().all() || !others.isFinite().all()) return std::nullopt;
    const Eigen::MatrixXd powers = powers_of_chebyshev(degree);
    const Eigen::MatrixXd coefficient = powers.transpose() * fitted(points, values, radius, degree) * powers;
    DiscPolynomial found(degree, radius);
    for (int j = degree; j >= 0; --j)
      for (int i = degree - j; i >= 0; --i) found.coefficient_.push_back(coefficient(i, j));
    const auto far_off = [&](const DiscPoints& where, const Eigen::ArrayXd& truth) {
      Eigen::ArrayXd miss = -truth;
      found.add(where.x.data(), where.y.data(), int(miss.size()), miss.data());
      return !(miss.abs().maxCoeff() <= error);
    };
    if (!far_off(points, values) && !far_off(between, others)) return found;
  }
  return std::nullopt;
}

void DiscPolynomial::add(const double* x, const double* y, int n, double* result, InstructionSet set) const {
  ABERFIT_KERNEL(set, add_polynomial)(coefficient_.data(), degree_, scale_, x, y, n, result);
}

}  // namespace aberfit::internal
