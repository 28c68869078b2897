#pragma once
#include <ceres/cost_function.h>

#include <memory>

#include "aberfit/fit/calibrate.h"
#include "aberfit/forward/forward_model.h"

namespace aberfit::internal {

/// Residuals x terms, row by row, because an adjoint pass fills a row.
using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Sizes of the parameter blocks of the white coordinates. They are small enough to keep the prior's identity
/// sparse, so that a CGNR step costs (residuals + kBlock) x terms.
std::vector<int> white_block_sizes(Eigen::Index terms);

/// White coordinates to statistics of the surface, with exact derivatives: xi -> F xi -> forward model. It
/// remembers the last point, where a solver requests values and then derivatives. For one caller at a time.
class StatisticsModel {
 public:
  StatisticsModel(const FitProblem& problem, double width,
                  int threads);  ///< statistics: targets, then guides

  /// Statistics at `white`; optionally their derivatives (statistics x terms). False when one does not exist.
  bool operator()(const Eigen::VectorXd& white, Eigen::VectorXd* values, Jacobian* jacobian);

  /// Sets the smoothing width [m].
  void set_width(double width);
  const ForwardModel& forward() const { return *forward_; }

 private:
  const CoefficientPrior& prior_;
  double width_;
  DiffractionWorkspace workspace_;
  std::unique_ptr<ForwardModel> forward_;
  // The last point: moved to unless `white_` is empty, evaluated if `evaluated_`.
  Eigen::VectorXd white_;
  bool evaluated_ = false, exists_ = false;
  Eigen::VectorXd values_;
};

/// Residuals of the white coordinates as one Ceres cost over all white blocks. It remembers the last point
/// with derivatives, which is the accepted point at the end of a solver iteration.
class WhiteResiduals : public ceres::CostFunction {
 public:
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

  struct Linearisation {
    Eigen::VectorXd white;
    Eigen::VectorXd values;  ///< compared with the targets: smooth statistics, PSD bins [m^4]
    Eigen::VectorXd residuals;
    Jacobian jacobian;  ///< of the residuals
  };
  /// Writes the residuals at `white`. With the Jacobian, the point is remembered and a repeated request costs
  /// nothing. Returns false if they do not exist.
  bool evaluate(const Eigen::VectorXd& white, bool with_jacobian, double* residuals) const;
  const Linearisation& last() const { return last_; }
  int evaluations() const { return evaluations_; }  ///< number of points, each counted once

  /// Values, residuals and optionally the Jacobian at `white`, without memory. Returns false if they do not
  /// exist.
  virtual bool linearise(const Eigen::VectorXd& white, bool with_jacobian, Linearisation* result) const = 0;

 protected:
  WhiteResiduals(int residuals, Eigen::Index terms);
  /// Discards the remembered point after a change of the residuals.
  void forget() { last_.white.resize(0); }

 private:
  mutable Linearisation here_, last_;  // swapped, so that both keep their storage
  mutable Eigen::VectorXd seen_;
  mutable int evaluations_ = 0;
};

/// (S_k - T_k) / tolerance_k, targets, then guides.
class FocusResiduals : public WhiteResiduals {
 public:
  FocusResiduals(const FitProblem& problem, double width, int threads);
  bool linearise(const Eigen::VectorXd& white, bool with_jacobian, Linearisation* result) const override;
  /// Sets the smoothing width [m].
  void set_width(double width) { model_.set_width(width); }
  const ForwardModel& forward() const { return model_.forward(); }

 private:
  std::vector<Target> targets_;    // followed by the guides
  mutable StatisticsModel model_;  // mutable because Ceres evaluates const cost functions
};

/// log(S_b / T_b) / tolerance_b of the surface's own PSD bins. False where a bin is not positive.
class SpectrumResiduals : public WhiteResiduals {
 public:
  explicit SpectrumResiduals(const FitProblem& problem);
  bool linearise(const Eigen::VectorXd& white, bool with_jacobian, Linearisation* result) const override;

 private:
  const FitProblem& problem_;
};

}  // namespace aberfit::internal
