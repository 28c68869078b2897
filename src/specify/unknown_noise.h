#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace aberfit::internal {

/// A way in which a measurement may differ from what it is taken for.
struct Departure {
  std::string remedy;        ///< what to do where the residuals point to it; no full stop
  Eigen::MatrixXd of_light;  ///< what it would add to the light, to a factor each: data x columns
};

/// Residuals of light whose noise nobody knows: its covariance is C + (level shape)^2, C one mirror's own
/// departure from the mean, and the level is that of the largest likelihood. Linear in what is fitted beside.
class UnknownNoiseResiduals {
 public:
  /// residuals: model - measured; design: its derivatives over what was fitted, data x parameters;
  /// own: C; shape: of the noise [unit of the light]; least: level below which none is taken.
  UnknownNoiseResiduals(const Eigen::VectorXd& residuals, const Eigen::MatrixXd& design,
                        const Eigen::MatrixXd& own, const Eigen::ArrayXd& shape, double least);

  /// Level of the noise by restricted maximum likelihood: of an even noise alone the root of the sum of
  /// squares over the degrees of freedom.
  double level() const;

  /// The chance that residuals of this noise alone would ask for columns more, as much as these do: the F
  /// distribution of the likelihood ratio, exact where C is zero. 1 where the columns say nothing new.
  /// without: a datum that is left out.
  double chance(const Eigen::MatrixXd& columns, std::optional<Eigen::Index> without = {}) const;

  /// The datum that lies farthest off, in the measure of the noise alone.
  Eigen::Index farthest() const { return farthest_; }

 private:
  struct Fit {
    double likelihood = 0;  // -2 log, but for a constant
    double restricted = 0;
  };
  Fit at(double log_level, const Eigen::MatrixXd& design) const;
  double best(const Eigen::MatrixXd& design, double Fit::*of, double* log_level) const;

  Eigen::MatrixXd turn_;    // rows: directions in which C is diagonal, over the shape
  Eigen::ArrayXd own_;      // C there
  Eigen::VectorXd values_;  // residuals there
  Eigen::MatrixXd design_;
  Eigen::Index farthest_ = 0;
  double least_, most_;  // log levels
};

/// Columns of what is smooth along a curve of so many data: the slowest cosines, one for each four data, at
/// most eight.
Eigen::MatrixXd smooth_columns(Eigen::Index data);

/// What residuals say of a fit.
struct ResidualVerdict {
  double chance = 1;   ///< of any of the departures so large, for the number of them that was looked at
  std::string remedy;  ///< of the one that the residuals point to
  /// One datum without which none of the departures is asked for: no form, but a mistake.
  std::optional<Eigen::Index> datum;
};
/// The last of the departures names no cause: it counts where the chance of none of the others is below
/// `poor`.
ResidualVerdict verdict_of(const UnknownNoiseResiduals& residuals, const std::vector<Departure>& departures,
                           double poor);

}  // namespace aberfit::internal
