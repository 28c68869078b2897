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
      nominal_(trace_nominal(problem.mirror, problem.pupil, threads)) {
  // Scatter angles look at directions only; the rest is an eighth of the memory of a fit.
  for (Eigen::ArrayXd* unread : {&nominal_.x, &nominal_.y, &nominal_.weight}) unread->resize(0);
  for (const Target& target : problem.targets) statistics_.push_back(target.statistic);
  for (const Target& guide : problem.guides) statistics_.push_back(guide.statistic);
}

void FocusModel::set_width(double width) {
  width_ = width;
  evaluated_ = false;
}

// The gradients over the rays come with the values: nearly every point that a solver tries is accepted, and
// then they cost a fraction of a second look at the rays.
bool FocusModel::evaluate(const Eigen::VectorXd& white) {
  if (white_.size() != white.size() || white_ != white) {
    problem_.surface.apply(problem_.prior.colour(white), &field_);
    trace(problem_.mirror, problem_.pupil, field_, threads_, &rays_);
    white_ = white;
    evaluated_ = false;
  }
  if (!evaluated_) {
    const FocusInput input{rays_, nominal_, field_.height, problem_.centre};
    exists_ = evaluate_smooth(input, statistics_, width_, threads_, &workspace_, &values_, &gradients_);
    evaluated_ = true;
  }
  return exists_;
}

Eigen::VectorXd FocusModel::white_gradient(std::size_t k) const {
  const RayGradient& rays = gradients_[k].rays;
  const SurfaceField weights = trace_adjoint(problem_.mirror, problem_.pupil, field_, rays);
  return problem_.prior.colour_transpose(rays.all_rays
                                             ? problem_.surface.apply_transpose(weights)
                                             : problem_.surface.apply_transpose(rays.rays, weights));
}

bool FocusModel::operator()(const Eigen::VectorXd& white, Eigen::VectorXd* values, Jacobian* jacobian) {
  const bool exists = evaluate(white);
  *values = values_;
  if (!exists || !jacobian) return exists;
  jacobian->resize(values->size(), white.size());

  // Dearest rows first, so that no thread is left with one at the end. Where these are fewer than threads,
  // they are taken one by one and the operator shares out their points.
  std::vector<std::size_t> sparse, dense;
  for (std::size_t k = 0; k < gradients_.size(); ++k) {
    Eigen::ArrayXd& d_height = gradients_[k].d_height;
    if (d_height.size() == 0) {
      (gradients_[k].rays.all_rays ? dense : sparse).push_back(k);
      continue;
    }
    if (height_weights_.slope_x.size() != d_height.size()) {  // its height is here only while it is used
      height_weights_.slope_x.setZero(d_height.size());
      height_weights_.slope_y.setZero(d_height.size());
    }
    height_weights_.height.swap(d_height);
    jacobian->row(Eigen::Index(k)) =
        problem_.prior.colour_transpose(problem_.surface.apply_transpose(height_weights_)).transpose();
    height_weights_.height.swap(d_height);
  }
  const auto fill = [&](std::size_t k) { jacobian->row(Eigen::Index(k)) = white_gradient(k).transpose(); };
  if (dense.size() < std::size_t(std::max(threads_, 1))) {
    for (const std::size_t k : dense) fill(k);
    dense.clear();
  }
  std::stable_sort(sparse.begin(), sparse.end(), [&](std::size_t a, std::size_t b) {
    return gradients_[a].rays.rays.size() > gradients_[b].rays.rays.size();
  });
  dense.insert(dense.end(), sparse.begin(), sparse.end());
  parallel_for(dense.size(), threads_, [&](std::size_t i) { fill(dense[i]); });
  return jacobian->allFinite();
}

WhiteResiduals::WhiteResiduals(int residuals, Eigen::Index terms) {
  set_num_residuals(residuals);
  *mutable_parameter_block_sizes() = white_block_sizes(terms);
}

bool WhiteResiduals::evaluate(const Eigen::VectorXd& white, bool with_jacobian, double* residuals) const {
  if (seen_.size() != white.size() || seen_ != white) {
    seen_ = white;
    ++evaluations_;
  }
  if (!linearise(white, with_jacobian, &here_)) return false;
  Eigen::Map<Eigen::VectorXd>(residuals, here_.residuals.size()) = here_.residuals;
  if (with_jacobian) std::swap(here_, last_);
  return true;
}

bool WhiteResiduals::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const std::vector<int>& sizes = parameter_block_sizes();
  Eigen::VectorXd white(std::accumulate(sizes.begin(), sizes.end(), Eigen::Index(0)));
  Eigen::Index begin = 0;
  for (std::size_t b = 0; b < sizes.size(); begin += sizes[b], ++b)
    white.segment(begin, sizes[b]) = Eigen::Map<const Eigen::VectorXd>(parameters[b], sizes[b]);

  if (!evaluate(white, jacobians != nullptr, residuals)) return false;
  if (!jacobians) return true;

  begin = 0;
  for (std::size_t b = 0; b < sizes.size(); begin += sizes[b], ++b) {
    if (!jacobians[b]) continue;
    Eigen::Map<Jacobian>(jacobians[b], last_.jacobian.rows(), sizes[b]) =
        last_.jacobian.middleCols(begin, sizes[b]);
  }
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
