#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace aberfit::internal {

/// A possible systematic error of a measurement.
struct Departure {
  std::string remedy;        ///< what to do if the residuals indicate it; no full stop
  Eigen::MatrixXd of_light;  ///< its effect on the energy, per unit factor: data x columns
};

/// Residuals of data with unknown noise. Their covariance is C + (level shape)^2, where C is that of one
/// mirror's deviation from the mean and the level maximises the likelihood. Linear in the other parameters.
class UnknownNoiseResiduals {
 public:
  /// residuals: model - measured; design: its derivatives over the fitted parameters, data x parameters; own:
  /// C; shape: of the noise [unit of the data]; least: lowest level.
  UnknownNoiseResiduals(const Eigen::VectorXd& residuals, const Eigen::MatrixXd& design,
                        const Eigen::MatrixXd& own, const Eigen::ArrayXd& shape, double least);

  /// Returns the level of the noise by restricted maximum likelihood. For uniform noise alone it is the root
  /// of the sum of squares over the degrees of freedom.
  double level() const;

  /// Returns the probability that this noise alone would require additional columns as much as these
  /// residuals do: F distribution of the likelihood ratio, exact if C is zero; 1 if the columns add nothing.
  /// without: datum to ignore.
  double chance(const Eigen::MatrixXd& columns, std::optional<Eigen::Index> without = {}) const;

  /// Returns the datum with the largest residual relative to the noise alone.
  Eigen::Index farthest() const { return farthest_; }

 private:
  struct Fit {
    double likelihood = 0;  // -2 log, up to a constant
    double restricted = 0;
  };
  Fit at(double log_level, const Eigen::MatrixXd& design) const;
  double best(const Eigen::MatrixXd& design, double Fit::*of, double* log_level) const;

  Eigen::MatrixXd turn_;    // rows: directions in which C is diagonal, divided by the shape
  Eigen::ArrayXd own_;      // C in these directions
  Eigen::VectorXd values_;  // residuals in these directions
  Eigen::MatrixXd design_;
  Eigen::Index farthest_ = 0;
  double least_, most_;  // logarithms of the level limits
};

/// Returns columns for a smooth deviation along a curve: the slowest cosines, one per four data, at most 8.
Eigen::MatrixXd smooth_columns(Eigen::Index data);

/// Evaluation of the residuals of a fit.
struct ResidualVerdict {
  double chance = 1;   ///< probability of so large a departure, corrected for the number examined
  std::string remedy;  ///< remedy for the indicated departure
  /// A single datum without which no departure is indicated: a mistake rather than structure.
  std::optional<Eigen::Index> datum;
};
/// Evaluates the departures. The last one names no cause; it counts only if no other is below `poor`.
ResidualVerdict verdict_of(const UnknownNoiseResiduals& residuals, const std::vector<Departure>& departures,
                           double poor);

}  // namespace aberfit::internal
