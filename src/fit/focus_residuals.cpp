#include "focus_residuals.h"

#include <algorithm>

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
    } else {
      gradient = problem_.surface.apply_transpose(
          gradients[k].rays.rays, trace_adjoint(problem_.mirror, problem_.pupil, field, gradients[k].rays));
    }
    jacobian->row(Eigen::Index(k)) = problem_.prior.colour_transpose(gradient).transpose();
  });
  return jacobian->allFinite();
}

FocusResiduals::FocusResiduals(const FitProblem& problem, double width, int threads)
    : problem_(problem), targets_(problem.targets), model_(problem, width, threads) {
  targets_.insert(targets_.end(), problem.guides.begin(), problem.guides.end());
  set_num_residuals(int(targets_.size()));
  *mutable_parameter_block_sizes() = white_block_sizes(problem.prior.size());
}

bool FocusResiduals::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  ++evaluations_;
  const std::vector<int>& sizes = parameter_block_sizes();
  Eigen::VectorXd white(problem_.prior.size());
  Eigen::Index begin = 0;
  for (std::size_t b = 0; b < sizes.size(); begin += sizes[b], ++b)
    white.segment(begin, sizes[b]) = Eigen::Map<const Eigen::VectorXd>(parameters[b], sizes[b]);

  Eigen::VectorXd values;
  Eigen::MatrixXd jacobian;
  if (!model_(white, &values, jacobians ? &jacobian : nullptr)) return false;
  Eigen::VectorXd scaled(values.size());
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const Target& target = targets_[std::size_t(k)];
    scaled[k] = (values[k] - target.value) / target.tolerance;
    if (jacobians) jacobian.row(k) /= target.tolerance;
  }
  Eigen::Map<Eigen::VectorXd>(residuals, scaled.size()) = scaled;
  if (!jacobians) return true;

  begin = 0;
  for (std::size_t b = 0; b < sizes.size(); begin += sizes[b], ++b) {
    if (!jacobians[b]) continue;
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor>(jacobians[b], jacobian.rows(), sizes[b]) = jacobian.middleCols(begin, sizes[b]);
  }
  last_ = {std::move(values), std::move(scaled), std::move(jacobian)};
  return true;
}

}  // namespace aberfit
