#include "calibration_residuals.h"

namespace aberfit::internal {
namespace {

int bins_of(const FitProblem& problem) { return problem.spectrum ? int(problem.spectrum->bins()) : 0; }

}  // namespace

CalibrationResiduals::CalibrationResiduals(const FitProblem& problem, double width, int threads)
    : WhiteResiduals(int(problem.targets.size() + problem.guides.size()) + bins_of(problem),
                     problem.prior.size()) {
  if (!problem.targets.empty() || !problem.guides.empty())
    focus_ = std::make_unique<FocusResiduals>(problem, width, threads);
  if (bins_of(problem) > 0) spectrum_ = std::make_unique<SpectrumResiduals>(problem);
}

void CalibrationResiduals::set_width(double width) {
  if (focus_) focus_->set_width(width);
  forget();
}

bool CalibrationResiduals::linearise(const Eigen::VectorXd& white, bool with_jacobian,
                                     Linearisation* result) const {
  if (!focus_ || !spectrum_) {
    const WhiteResiduals* only = focus_.get();
    if (!only) only = spectrum_.get();
    return only->linearise(white, with_jacobian, result);
  }
  Linearisation bins;
  if (!focus_->linearise(white, with_jacobian, result) || !spectrum_->linearise(white, with_jacobian, &bins))
    return false;
  const Eigen::Index first = result->residuals.size(), count = bins.residuals.size();
  result->values.conservativeResize(first + count);
  result->values.tail(count) = bins.values;
  result->residuals.conservativeResize(first + count);
  result->residuals.tail(count) = bins.residuals;
  if (with_jacobian) {
    result->jacobian.conservativeResize(first + count, Eigen::NoChange);
    result->jacobian.bottomRows(count) = bins.jacobian;
  }
  return true;
}

}  // namespace aberfit::internal
