#include "focus_residuals.h"

#include <algorithm>
#include <numeric>

#include "aberfit/core/parallel.h"

namespace aberfit {
namespace {

constexpr int kBlock = 16;

}  // namespace

std::vector<int> white_block_sizes(Eigen::Index terms) {
  std::vector<int> sizes(std::size_t(terms / kBlock), kBlock);
  if (terms % kBlock != 0) sizes.push_back(int(terms % kBlock));
  return sizes;
}

FocusModel::FocusModel(const FitProblem& problem, double width, int threads)
    : problem_(problem),
      width_(width),
      threads_(threads),
      nominal_(trace_nominal(problem.mirror, problem.pupil)) {
  for (const Target& target : problem.targets) statistics_.push_back(target.statistic);
  for (const Target& guide : problem.guides) statistics_.push_back(guide.statistic);
}

bool FocusModel::operator()(const Eigen::VectorXd& white, Eigen::VectorXd* values,
                            Eigen::MatrixXd* jacobian) const {
  SurfaceField field;
  problem_.surface.apply(problem_.prior.colour(white), &field);
  const RayBundle rays = trace(problem_.mirror, problem_.pupil, field);
  const FocusInput input{rays, nominal_, field.height, problem_.centre};
  std::vector<StatisticGradient> gradients;
  if (!evaluate_smooth(input, statistics_, width_, threads_, values, jacobian ? &gradients : nullptr))
    return false;
  if (!jacobian) return true;

  jacobian->resize(values->size(), white.size());
  parallel_for(statistics_.size(), threads_, [&](std::size_t k) {
    Eigen::VectorXd gradient;
    if (gradients[k].d_height.size() > 0) {
      SurfaceField weights{gradients[k].d_height, Eigen::ArrayXd::Zero(field.size()),
                           Eigen::ArrayXd::Zero(field.size())};
      gradient = problem_.surface.apply_transpose(weights);
    } else if (gradients[k].rays.all_rays) {
      gradient = problem_.surface.apply_transpose(
          trace_adjoint(problem_.mirror, problem_.pupil, field, gradients[k].rays));
    } else {
      gradient = problem_.surface.apply_transpose(
          gradients[k].rays.rays, trace_adjoint(problem_.mirror, problem_.pupil, field, gradients[k].rays));
    }
    jacobian->row(Eigen::Index(k)) = problem_.prior.colour_transpose(gradient).transpose();
  });
  return jacobian->allFinite();
}

WhiteResiduals::WhiteResiduals(int residuals, Eigen::Index terms) {
  set_num_residuals(residuals);
  *mutable_parameter_block_sizes() = white_block_sizes(terms);
}

bool WhiteResiduals::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  ++evaluations_;
  const std::vector<int>& sizes = parameter_block_sizes();
  Eigen::VectorXd white(std::accumulate(sizes.begin(), sizes.end(), Eigen::Index(0)));
  Eigen::Index begin = 0;
  for (std::size_t b = 0; b < sizes.size(); begin += sizes[b], ++b)
    white.segment(begin, sizes[b]) = Eigen::Map<const Eigen::VectorXd>(parameters[b], sizes[b]);

  Linearisation here;
  if (!linearise(white, jacobians != nullptr, &here)) return false;
  Eigen::Map<Eigen::VectorXd>(residuals, here.residuals.size()) = here.residuals;
  if (!jacobians) return true;

  begin = 0;
  for (std::size_t b = 0; b < sizes.size(); begin += sizes[b], ++b) {
    if (!jacobians[b]) continue;
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor>(jacobians[b], here.jacobian.rows(), sizes[b]) =
        here.jacobian.middleCols(begin, sizes[b]);
  }
  last_ = std::move(here);
  return true;
}

FocusResiduals::FocusResiduals(const FitProblem& problem, double width, int threads)
    : WhiteResiduals(int(problem.targets.size() + problem.guides.size()), problem.prior.size()),
      targets_(problem.targets),
      model_(problem, width, threads) {
  targets_.insert(targets_.end(), problem.guides.begin(), problem.guides.end());
}

bool FocusResiduals::linearise(const Eigen::VectorXd& white, bool with_jacobian,
                               Linearisation* result) const {
  if (!model_(white, &result->values, with_jacobian ? &result->jacobian : nullptr)) return false;
  result->residuals.resize(result->values.size());
  for (Eigen::Index k = 0; k < result->values.size(); ++k) {
    const Target& target = targets_[std::size_t(k)];
    result->residuals[k] = (result->values[k] - target.value) / target.tolerance;
    if (with_jacobian) result->jacobian.row(k) /= target.tolerance;
  }
  return true;
}

SpectrumResiduals::SpectrumResiduals(const FitProblem& problem)
    : WhiteResiduals(int(problem.spectrum->bins()), problem.prior.size()), problem_(problem) {}

bool SpectrumResiduals::linearise(const Eigen::VectorXd& white, bool with_jacobian,
                                  Linearisation* result) const {
  Eigen::MatrixXd slopes;  // dS/dc
  problem_.spectrum->evaluate(problem_.prior.colour(white), &result->values,
                              with_jacobian ? &slopes : nullptr);
  const Eigen::ArrayXd bins = result->values;
  if (!bins.isFinite().all() || !(bins > 0).all()) return false;
  const Eigen::ArrayXd tolerance = problem_.spectrum_tolerance;
  result->residuals = (bins / problem_.spectrum_target.array()).log() / tolerance;
  if (with_jacobian) {
    // d log S = dS / S;
    result->jacobian.resize(bins.size(), white.size());
    for (Eigen::Index b = 0; b < bins.size(); ++b)
      result->jacobian.row(b) =
          problem_.prior.colour_transpose((slopes.row(b) / (bins[b] * tolerance[b])).transpose()).transpose();
    return result->jacobian.allFinite();
  }
  return result->residuals.allFinite();
}

}  // namespace aberfit
