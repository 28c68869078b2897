#pragma once
#include <memory>

#include "focus_residuals.h"

namespace aberfit::internal {

/// All surface residuals of a calibration: of the targets, of the guides, then of the PSD bins.
class CalibrationResiduals : public WhiteResiduals {
 public:
  CalibrationResiduals(const FitProblem& problem, double width, int threads);
  bool linearise(const Eigen::VectorXd& white, bool with_jacobian, Linearisation* result) const override;
  /// Sets the smoothing width [m].
  void set_width(double width);

  const FocusResiduals* focus() const { return focus_.get(); }           ///< null without targets and guides
  const SpectrumResiduals* spectrum() const { return spectrum_.get(); }  ///< null without PSD bins

 private:
  std::unique_ptr<FocusResiduals> focus_;
  std::unique_ptr<SpectrumResiduals> spectrum_;
};

}  // namespace aberfit::internal
