#pragma once
#include <memory>

#include "focus_residuals.h"

namespace aberfit::internal {

/// The residual blocks of a calibration: focal statistics, PSD bins, or both. All see the same white
/// coordinates.
struct CalibrationBlocks {
  std::unique_ptr<FocusResiduals> focus;        ///< null without targets and guides
  std::unique_ptr<SpectrumResiduals> spectrum;  ///< null without PSD bins

  CalibrationBlocks(const FitProblem& problem, double width, int threads);

  bool empty() const { return !focus && !spectrum; }
  int residuals() const;
  int evaluations() const;
  /// Residuals at `white`, focus before spectrum; with the Jacobian every block remembers the point. False
  /// where a residual does not exist.
  bool evaluate(const Eigen::VectorXd& white, bool with_jacobian, double* residuals) const;
  /// Whether every block has a point with derivatives behind it.
  bool complete() const;
  /// Jacobian of all residuals at the last such point into the first rows of `all`.
  void copy_jacobian(Jacobian* all) const;
};

}  // namespace aberfit::internal
