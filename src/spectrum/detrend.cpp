#include "aberfit/spectrum/detrend.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include "aberfit/core/linear_algebra.h"
#include "aberfit/core/quadrature.h"
#include "detrend_basis.h"

namespace aberfit {
using namespace internal;

namespace {

// Fits least-squares coefficients to the valid rows and returns basis * coefficients. A rank-deficient basis
// (few samples) gives the smallest coefficients.
Eigen::ArrayXd fitted(const Eigen::MatrixXd& basis, const Eigen::ArrayXd& value) {
  std::vector<Eigen::Index> valid;
  for (Eigen::Index i = 0; i < value.size(); ++i)
    if (std::isfinite(value[i])) valid.push_back(i);
  if (valid.empty()) return Eigen::ArrayXd::Zero(value.size());
  const Eigen::MatrixXd rows = basis(valid, Eigen::all);
  const Eigen::VectorXd right = value(valid).matrix();
  return basis * LeastNorm(rows).solve(right);
}

Profile minus_polynomial(const Profile& profile, int degree) {
  Profile result = profile;
  if (profile.quantity == ProfileQuantity::kSlope) --degree;
  if (degree < 0 || profile.size() == 0) return result;
  const double low = profile.x[0], high = profile.x[profile.size() - 1];
  result.value -= fitted(legendre_basis(profile.x, low, high, degree), profile.value);
  return result;
}

template <class Values>
double rms_of_valid(const Values& values) {
  double sum = 0, count = 0;
  for (const double v : values)
    if (std::isfinite(v)) sum += v * v, ++count;
  return count > 0 ? std::sqrt(sum / count) : 0;
}

}  // namespace

namespace internal {

Eigen::MatrixXd legendre_basis(const Eigen::ArrayXd& x, double low, double high, int degree) {
  const Eigen::ArrayXd t = high > low ? Eigen::ArrayXd((2 * x - low - high) / (high - low))
                                      : Eigen::ArrayXd(Eigen::ArrayXd::Zero(x.size()));
  return legendre_polynomials(t, degree + 1).matrix();
}

std::vector<std::pair<int, int>> products_up_to(int degree) {
  std::vector<std::pair<int, int>> products;
  for (int total = 0; total <= degree; ++total)
    for (int j = 0; j <= total; ++j) products.emplace_back(total - j, j);
  return products;
}

int polynomial_degree(const DetrendOptions& options, bool profile) {
  if (options.shape == DetrendShape::kNone) return -1;
  if (options.shape == DetrendShape::kEllipse) return profile ? 4 : 2;
  return options.degree;
}

}  // namespace internal

Profile heights_of(const Profile& profile) {
  if (profile.quantity == ProfileQuantity::kHeight) return profile;
  Profile result = profile;
  result.quantity = ProfileQuantity::kHeight;
  const Eigen::Index n = profile.size();
  Eigen::ArrayXd slope = profile.value;
  Eigen::Index last = -1;  // last valid sample so far
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!std::isfinite(slope[i])) continue;
    for (Eigen::Index k = last + 1; k < i; ++k) {
      const double t = last < 0 ? 1 : (profile.x[k] - profile.x[last]) / (profile.x[i] - profile.x[last]);
      slope[k] = t * slope[i] + (last < 0 ? 0 : (1 - t) * slope[last]);
    }
    last = i;
  }
  double height = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (i > 0 && i <= last) height += 0.5 * (slope[i] + slope[i - 1]) * (profile.x[i] - profile.x[i - 1]);
    if (std::isfinite(profile.value[i])) result.value[i] = height;
  }
  return result;
}

Profile detrend(const Profile& profile, const DetrendOptions& options) {
  if (options.shape == DetrendShape::kNone) return profile;
  if (options.degree < 0 && options.shape != DetrendShape::kEllipse)
    throw std::invalid_argument("detrend.degree must be 0 or more, is " + std::to_string(options.degree));
  if (options.shape == DetrendShape::kEllipse) {
    const EllipseFit ellipse = fit_ellipse(profile);
    if (!ellipse.converged) return minus_polynomial(profile, 2);
    Profile result = profile;
    result.value -= ellipse.shape;
    return result;
  }
  return minus_polynomial(profile, options.degree);
}

HeightMap detrend(const HeightMap& map, const DetrendOptions& options) {
  const int degree = polynomial_degree(options, false);
  if (options.shape == DetrendShape::kNone || map.height.size() == 0) return map;
  if (degree < 0)
    throw std::invalid_argument("detrend.degree must be 0 or more, is " + std::to_string(options.degree));
  const Eigen::Index columns = map.columns(), rows = map.rows();
  const auto across = legendre_basis(Eigen::ArrayXd::LinSpaced(columns, 0, double(columns - 1)), 0,
                                     double(columns - 1), degree);
  const auto down =
      legendre_basis(Eigen::ArrayXd::LinSpaced(rows, 0, double(rows - 1)), 0, double(rows - 1), degree);
  const std::vector<std::pair<int, int>> products = products_up_to(degree);
  const Eigen::Index terms = Eigen::Index(products.size());
  HeightMap result = map;
  Eigen::VectorXd term(terms);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(terms, terms);
  const auto at = [&](Eigen::Index row, Eigen::Index column) -> const Eigen::VectorXd& {
    for (Eigen::Index k = 0; k < terms; ++k)
      term[k] = across(column, products[std::size_t(k)].first) * down(row, products[std::size_t(k)].second);
    return term;
  };
  for (Eigen::Index r = 0; r < rows; ++r)
    for (Eigen::Index c = 0; c < columns; ++c)
      if (std::isfinite(map.height(r, c))) gram.selfadjointView<Eigen::Lower>().rankUpdate(at(r, c));
  const Eigen::MatrixXd full = gram.selfadjointView<Eigen::Lower>();
  const LeastNorm solver(full);
  for (int pass = 0; pass < 2; ++pass) {  // the second pass removes the rounding of the normal equations
    Eigen::VectorXd right = Eigen::VectorXd::Zero(terms);
    for (Eigen::Index r = 0; r < rows; ++r)
      for (Eigen::Index c = 0; c < columns; ++c)
        if (std::isfinite(result.height(r, c))) right += result.height(r, c) * at(r, c);
    const Eigen::VectorXd coefficient = solver.solve(right);
    for (Eigen::Index r = 0; r < rows; ++r)
      for (Eigen::Index c = 0; c < columns; ++c)
        if (std::isfinite(result.height(r, c))) result.height(r, c) -= coefficient.dot(at(r, c));
  }
  return result;
}

double rms(const Profile& profile) { return rms_of_valid(profile.value); }

double rms(const HeightMap& map) { return rms_of_valid(map.height.reshaped()); }

}  // namespace aberfit
