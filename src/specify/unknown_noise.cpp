#include "unknown_noise.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>

#include "aberfit/core/constants.h"

namespace aberfit::internal {
namespace {

constexpr int kLevels = 40, kRefined = 30;  // steps of the search for a level
constexpr double kNothingNew = 1e-6;        // fraction of a column that the design leaves
constexpr Eigen::Index kDataOfColumn = 4, kMostColumns = 8;

// Upper tail of the F distribution with k and n degrees of freedom.
double tail_of_f(double ratio, double k, double n) {
  return boost::math::ibeta(0.5 * n, 0.5 * k, n / (n + k * std::max(ratio, 0.0)));
}

}  // namespace

UnknownNoiseResiduals::UnknownNoiseResiduals(const Eigen::VectorXd& residuals, const Eigen::MatrixXd& design,
                                             const Eigen::MatrixXd& own, const Eigen::ArrayXd& shape,
                                             double least) {
  const Eigen::VectorXd over = shape.inverse().matrix();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(over.asDiagonal() * own * over.asDiagonal());
  turn_ = axes.eigenvectors().transpose() * over.asDiagonal();
  own_ = axes.eigenvalues().array().max(0.0);
  values_ = turn_ * residuals;
  (over.array() * residuals.array()).abs().maxCoeff(&farthest_);
  design_ = turn_ * design;
  least_ = std::log(least);
  most_ = std::max(least_, std::log(std::max(values_.cwiseAbs().maxCoeff(), 1e-300)) + 1) + 1;
}

UnknownNoiseResiduals::Fit UnknownNoiseResiduals::at(double log_level, const Eigen::MatrixXd& design) const {
  const Eigen::ArrayXd variance = own_ + std::exp(2 * log_level);
  const Eigen::MatrixXd weighted = variance.inverse().matrix().asDiagonal() * design;
  const Eigen::LDLT<Eigen::MatrixXd> normal(design.transpose() * weighted);
  const Eigen::VectorXd left = values_ - design * normal.solve(weighted.transpose() * values_);
  Fit fit;
  fit.likelihood = variance.log().sum() + (left.array().square() / variance).sum();
  fit.restricted = fit.likelihood + normal.vectorD().array().abs().max(1e-300).log().sum();
  return fit;
}

double UnknownNoiseResiduals::best(const Eigen::MatrixXd& design, double Fit::*of, double* log_level) const {
  const double step = (most_ - least_) / kLevels;
  double place = least_, least = at(least_, design).*of;
  for (int k = 1; k <= kLevels; ++k)
    if (const double here = at(least_ + k * step, design).*of; here < least)
      least = here, place = least_ + k * step;
  double low = std::max(least_, place - step), high = place + step;
  for (int k = 0; k < kRefined; ++k) {
    const double a = low + 0.382 * (high - low), b = low + 0.618 * (high - low);
    (at(a, design).*of < at(b, design).*of ? high : low) = at(a, design).*of < at(b, design).*of ? b : a;
  }
  place = 0.5 * (low + high);
  if (log_level) *log_level = place;
  return std::min(least, at(place, design).*of);
}

double UnknownNoiseResiduals::level() const {
  double log_level = 0;
  best(design_, &Fit::restricted, &log_level);
  return std::exp(log_level);
}

double UnknownNoiseResiduals::chance(const Eigen::MatrixXd& columns,
                                     std::optional<Eigen::Index> without) const {
  // Keeps the part of each column that the design does not contain, in the metric of the noise alone.
  Eigen::MatrixXd plain = design_;
  if (without) {
    plain.conservativeResize(Eigen::NoChange, plain.cols() + 1);
    plain.rightCols(1) = turn_.col(*without).normalized();
  }
  Eigen::MatrixXd design = plain;
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    const Eigen::VectorXd column = turn_ * columns.col(c);
    const Eigen::VectorXd rest =
        column - design * design.completeOrthogonalDecomposition().solve(column).eval();
    if (!(rest.norm() > kNothingNew * column.norm())) continue;
    design.conservativeResize(Eigen::NoChange, design.cols() + 1);
    design.rightCols(1) = rest / rest.norm();
  }
  const double more = double(design.cols() - plain.cols()), data = double(values_.size());
  const double freedom = data - double(design.cols());
  if (!(more > 0 && freedom > 0)) return 1;
  const double ratio = best(plain, &Fit::likelihood, nullptr) - best(design, &Fit::likelihood, nullptr);
  return tail_of_f(freedom / more * std::expm1(std::max(0.0, ratio) / data), more, freedom);
}

Eigen::MatrixXd smooth_columns(Eigen::Index data) {
  const Eigen::Index count = std::clamp<Eigen::Index>(data / kDataOfColumn, 1, kMostColumns);
  Eigen::MatrixXd columns(data, count);
  for (Eigen::Index k = 0; k < count; ++k)
    for (Eigen::Index i = 0; i < data; ++i)
      columns(i, k) = std::cos(kPi * double(k) * (double(i) + 0.5) / double(data));
  return columns;
}

ResidualVerdict verdict_of(const UnknownNoiseResiduals& residuals, const std::vector<Departure>& departures,
                           double poor) {
  const double count = double(departures.size());
  ResidualVerdict verdict;
  for (const Departure& departure : departures) {
    const double chance = std::min(1.0, count * residuals.chance(departure.of_light));
    const bool names_none = &departure == &departures.back();
    if (chance < verdict.chance && !(names_none && verdict.chance < poor)) verdict.remedy = departure.remedy;
    verdict.chance = std::min(verdict.chance, chance);
  }
  if (verdict.chance < poor) {
    double without = 1;
    for (const Departure& departure : departures)
      without = std::min(without, count * residuals.chance(departure.of_light, residuals.farthest()));
    if (without >= poor) verdict.datum = residuals.farthest();
  }
  if (verdict.remedy.empty() && !departures.empty()) verdict.remedy = departures.back().remedy;
  return verdict;
}

}  // namespace aberfit::internal
