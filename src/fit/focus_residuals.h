#pragma once
#include <ceres/cost_function.h>

#include <memory>

#include "aberfit/fit/calibrate.h"
#include "aberfit/forward/forward_model.h"

namespace aberfit::internal {

/// Residuals x terms, one statistic after the other: an adjoint pass fills a row.
using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Sizes of the parameter blocks that the white coordinates are cut into: small enough that the prior's
/// identity stays sparse, so that a CGNR step costs (residuals + kBlock) x terms.
std::vector<int> white_block_sizes(Eigen::Index terms);

/// White coordinates to statistics of the surface, with exact derivatives: xi -> F xi -> forward model of the
/// problem's model. Remembers the last point: a solver asks for the derivatives where it has just asked for
/// the values. For one caller at a time.
class StatisticsModel {
 public:
  StatisticsModel(const FitProblem& problem, double width,
                  int threads);  ///< statistics: targets, then guides

  /// Statistics at `white`; `jacobian` (statistics x terms), when given, gets their derivatives. False when
  /// one does not exist.
  bool operator()(const Eigen::VectorXd& white, Eigen::VectorXd* values, Jacobian* jacobian);

  /// Smoothing width [m] from now on.
  void set_width(double width);
  const ForwardModel& forward() const { return *forward_; }

 private:
  const CoefficientPrior& prior_;
  double width_;
  DiffractionWorkspace workspace_;
  std::unique_ptr<ForwardModel> forward_;
  // The last point: moved to where `white_` is not empty, evaluated where `evaluated_` says so.
  Eigen::VectorXd white_;
  bool evaluated_ = false, exists_ = false;
  Eigen::VectorXd values_;
};

/// Residuals of the white coordinates as one Ceres cost over all white blocks. Remembers values, residuals
/// and Jacobian of the last point at which derivatives were asked for: that is the accepted point when an
/// iteration of the solver ends.
class WhiteResiduals : public ceres::CostFunction {
 public:
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

  struct Linearisation {
    Eigen::VectorXd white;   ///< the point
    Eigen::VectorXd values;  ///< what is compared with the targets: smooth statistics, PSD bins [m^4]
    Eigen::VectorXd residuals;
    Jacobian jacobian;  ///< of the residuals
  };
  /// Residuals at `white` into `residuals`; with the Jacobian the point is remembered, and costs nothing when
  /// asked for again. False where they do not exist.
  bool evaluate(const Eigen::VectorXd& white, bool with_jacobian, double* residuals) const;
  const Linearisation& last() const { return last_; }
  int evaluations() const { return evaluations_; }  ///< number of points, each counted once

  /// Values and residuals at `white` and, when asked for, the residuals' Jacobian, without a memory. False
  /// where they do not exist.
  virtual bool linearise(const Eigen::VectorXd& white, bool with_jacobian, Linearisation* result) const = 0;

 protected:
  WhiteResiduals(int residuals, Eigen::Index terms);
  /// The residuals are others from now on: the remembered point has to be evaluated anew.
  void forget() { last_.white.resize(0); }

 private:
  mutable Linearisation here_, last_;  // exchanged, so that neither's memory is lost
  mutable Eigen::VectorXd seen_;
  mutable int evaluations_ = 0;
};

/// (S_k - T_k) / tolerance_k, targets, then guides.
class FocusResiduals : public WhiteResiduals {
 public:
  FocusResiduals(const FitProblem& problem, double width, int threads);
  bool linearise(const Eigen::VectorXd& white, bool with_jacobian, Linearisation* result) const override;
  /// Smoothing width [m] from now on.
  void set_width(double width) { model_.set_width(width); }
  const ForwardModel& forward() const { return model_.forward(); }

 private:
  std::vector<Target> targets_;  // with the guides behind them
  mutable StatisticsModel
      model_;  // Ceres evaluates constant cost functions; the memory is no part of the value
};

/// log(S_b / T_b) / tolerance_b of the surface's own PSD bins. False where a bin is not positive: there its
/// logarithm has no value.
class SpectrumResiduals : public WhiteResiduals {
 public:
  explicit SpectrumResiduals(const FitProblem& problem);
  bool linearise(const Eigen::VectorXd& white, bool with_jacobian, Linearisation* result) const override;

 private:
  const FitProblem& problem_;
};

}  // namespace aberfit::internal
