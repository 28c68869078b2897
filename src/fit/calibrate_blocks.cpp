#include "calibrate_blocks.h"

#include <algorithm>

namespace aberfit::internal {

CalibrationBlocks::CalibrationBlocks(const FitProblem& problem, double width, int threads) {
  if (!problem.targets.empty() || !problem.guides.empty())
    focus = std::make_unique<FocusResiduals>(problem, width, threads);
  if (problem.spectrum && problem.spectrum->bins() > 0)
    spectrum = std::make_unique<SpectrumResiduals>(problem);
}

int CalibrationBlocks::residuals() const {
  return (focus ? focus->num_residuals() : 0) + (spectrum ? spectrum->num_residuals() : 0);
}

int CalibrationBlocks::evaluations() const {
  return std::max(focus ? focus->evaluations() : 0, spectrum ? spectrum->evaluations() : 0);
}

bool CalibrationBlocks::evaluate(const Eigen::VectorXd& white, bool with_jacobian, double* residuals) const {
  if (focus && !focus->evaluate(white, with_jacobian, residuals)) return false;
  if (focus) residuals += focus->num_residuals();
  return !spectrum || spectrum->evaluate(white, with_jacobian, residuals);
}

bool CalibrationBlocks::complete() const {
  return (!focus || focus->last().residuals.size() > 0) &&
         (!spectrum || spectrum->last().residuals.size() > 0);
}

void CalibrationBlocks::copy_jacobian(Jacobian* all) const {
  Eigen::Index row = 0;
  for (const WhiteResiduals* block : {static_cast<const WhiteResiduals*>(focus.get()),
                                      static_cast<const WhiteResiduals*>(spectrum.get())}) {
    if (!block) continue;
    all->middleRows(row, block->last().jacobian.rows()) = block->last().jacobian;
    row += block->last().jacobian.rows();
  }
}

}  // namespace aberfit::internal
