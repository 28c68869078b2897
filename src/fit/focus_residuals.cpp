#include "focus_residuals.h"

#include <numeric>

namespace aberfit::internal {
namespace {

constexpr int kBlock = 16;
}  // namespace

std::vector<int> white_block_sizes(Eigen::Index terms) {
  std::vector<int> sizes(std::size_t(terms / kBlock), kBlock);
  if (terms % kBlock != 0) sizes.push_back(int(terms % kBlock));
  return sizes;
}

StatisticsModel::StatisticsModel(const FitProblem& problem, double width, int threads)
    : prior_(problem.prior), width_(width) {
  std::vector<Statistic> statistics = statistics_of(problem.targets);
  const std::vector<Statistic> guides = statistics_of(problem.guides);
  statistics.insert(statistics.end(), guides.begin(), guides.end());
  workspace_.follow_rings();
  LightPath path = problem.light;
  path.workspace = &workspace_;
  forward_ = make_forward_model(path, statistics, threads);
}

void StatisticsModel::set_width(double width) {
  width_ = width;
  evaluated_ = false;
}

bool StatisticsModel::operator()(const Eigen::VectorXd& white, Eigen::VectorXd* values, Jacobian* jacobian) {
  if (white_.size() != white.size() || white_ != white) {
    forward_->move_to(prior_.colour(white));
    white_ = white;
    evaluated_ = false;
  }
  if (!evaluated_) {
    exists_ = forward_->evaluate(width_, &values_);
    evaluated_ = true;
  }
  *values = values_;
  if (!exists_ || !jacobian) return exists_;
  jacobian->resize(values->size(), white.size());
  const bool derivatives = forward_->gradients([&](std::size_t k, const Eigen::VectorXd& gradient) {
    jacobian->row(Eigen::Index(k)) = prior_.colour_transpose(gradient).transpose();
  });
  return derivatives && jacobian->allFinite();
}

WhiteResiduals::WhiteResiduals(int residuals, Eigen::Index terms) {
  set_num_residuals(residuals);
  *mutable_parameter_block_sizes() = white_block_sizes(terms);
}

bool WhiteResiduals::evaluate(const Eigen::VectorXd& white, bool with_jacobian, double* residuals) const {
  if (last_.white.size() == white.size() && last_.white == white) {
    Eigen::Map<Eigen::VectorXd>(residuals, last_.residuals.size()) = last_.residuals;
    return true;
  }
  if (seen_.size() != white.size() || seen_ != white) {
    seen_ = white;
    ++evaluations_;
  }
  if (!linearise(white, with_jacobian, &here_)) return false;
  Eigen::Map<Eigen::VectorXd>(residuals, here_.residuals.size()) = here_.residuals;
  if (with_jacobian) {
    here_.white = white;
    std::swap(here_, last_);
  }
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
    // d log S = dS / S
    result->jacobian.resize(bins.size(), white.size());
    for (Eigen::Index b = 0; b < bins.size(); ++b)
      result->jacobian.row(b) =
          problem_.prior.colour_transpose((slopes.row(b) / (bins[b] * tolerance[b])).transpose()).transpose();
    return result->jacobian.allFinite();
  }
  return result->residuals.allFinite();
}

}  // namespace aberfit::internal
