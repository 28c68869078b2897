#include "aberfit/fit/calibrate.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "focus_residuals.h"
#include "posterior.h"

namespace aberfit {
namespace {

// xi - xi0 of one block.
class PriorResiduals : public ceres::CostFunction {
 public:
  explicit PriorResiduals(Eigen::VectorXd centre) : centre_(std::move(centre)) {
    set_num_residuals(int(centre_.size()));
    mutable_parameter_block_sizes()->push_back(int(centre_.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Index n = centre_.size();
    Eigen::Map<Eigen::VectorXd>(residuals, n) = Eigen::Map<const Eigen::VectorXd>(parameters[0], n) - centre_;
    if (jacobians && jacobians[0]) Eigen::Map<Eigen::MatrixXd>(jacobians[0], n, n).setIdentity();
    return true;
  }

 private:
  Eigen::VectorXd centre_;
};

// Largest residual of the targets; the guides behind them do not count.
double worst_mismatch(const FitProblem& problem, const Eigen::VectorXd& residuals) {
  return residuals.size() == 0 ? 0.0
                               : residuals.head(Eigen::Index(problem.targets.size())).cwiseAbs().maxCoeff();
}

// Ends a solve as soon as every statistic is within tolerance, reports progress, and hears a wish to cancel.
class Watch : public ceres::IterationCallback {
 public:
  Watch(const FitProblem& problem, const FocusResiduals& residuals, const FitOptions& options,
        int iterations_before, std::chrono::steady_clock::time_point begin)
      : problem_(problem),
        residuals_(residuals),
        options_(options),
        iterations_before_(iterations_before),
        begin_(begin) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    const double mismatch = worst_mismatch(problem_, residuals_.last().residuals);
    if (options_.progress) {
      const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin_;
      if (!options_.progress(
              {iterations_before_ + summary.iteration, summary.cost, mismatch, elapsed.count()})) {
        cancelled_ = true;
        return ceres::SOLVER_ABORT;
      }
    }
    if (mismatch <= options_.stop_at) return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    return ceres::SOLVER_CONTINUE;
  }
  bool cancelled() const { return cancelled_; }

 private:
  const FitProblem& problem_;
  const FocusResiduals& residuals_;
  const FitOptions& options_;
  int iterations_before_;
  std::chrono::steady_clock::time_point begin_;
  bool cancelled_ = false;
};

ceres::Solver::Options solver_options(int iterations) {
  ceres::Solver::Options options;
  options.max_num_iterations = iterations;
  // Identity plus low rank: conjugate gradients end after about as many steps as there are statistics,
  // whatever the number of terms.
  options.linear_solver_type = ceres::CGNR;
  options.preconditioner_type = ceres::IDENTITY;
  options.jacobi_scaling = false;  // the problem is whitened already
  options.max_linear_solver_iterations = 300;
  options.eta = 1e-3;  // a step costs far less than the Jacobian it uses: solve it well
  options.function_tolerance = 1e-9;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-10;
  options.logging_type = ceres::SILENT;
  options.update_state_every_iteration = true;
  return options;
}

struct Solve {
  FitStatus status;
  std::string message;
};

// One solve at one smoothing width from result->white, which it moves.
Solve solve_once(const FitProblem& problem, const Eigen::VectorXd& centre, const FitOptions& options,
                 double width, std::chrono::steady_clock::time_point begin,
                 FocusResiduals::Linearisation* last, FitResult* result) {
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  FocusResiduals residuals(problem, width * problem.focal_sigma, options.threads);
  std::vector<std::unique_ptr<PriorResiduals>> priors;
  ceres::Problem ceres_problem(ownership);
  std::vector<double*> blocks;
  Eigen::Index at = 0;
  for (const int size : residuals.parameter_block_sizes()) {
    blocks.push_back(result->white.data() + at);
    ceres_problem.AddParameterBlock(blocks.back(), size);
    priors.push_back(std::make_unique<PriorResiduals>(centre.segment(at, size)));
    ceres_problem.AddResidualBlock(priors.back().get(), nullptr, blocks.back());
    for (int i = 0; options.bound > 0 && i < size; ++i) {
      ceres_problem.SetParameterLowerBound(blocks.back(), i, -options.bound);
      ceres_problem.SetParameterUpperBound(blocks.back(), i, options.bound);
    }
    at += size;
  }
  ceres_problem.AddResidualBlock(&residuals, nullptr, blocks);

  Watch watch(problem, residuals, options, result->iterations, begin);
  ceres::Solver::Options ceres_options =
      solver_options(std::max(0, options.max_iterations - result->iterations));
  ceres_options.callbacks.push_back(&watch);
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options, &ceres_problem, &summary);

  result->iterations += std::max(0, int(summary.iterations.size()) - 1);
  result->evaluations += residuals.evaluations();
  result->final_cost = summary.final_cost;
  *last = residuals.last();
  if (watch.cancelled()) return {FitStatus::kCancelled, "cancelled"};
  if (!summary.IsSolutionUsable() || last->residuals.size() == 0)
    return {FitStatus::kFailed, "the solver failed: " + summary.message};
  const double mismatch = worst_mismatch(problem, last->residuals);
  if (mismatch <= options.stop_at)
    return {FitStatus::kConverged,
            fmt::format("every statistic is within {:.2g} of its tolerance", mismatch)};
  if (summary.termination_type == ceres::CONVERGENCE)
    return {FitStatus::kConverged,
            fmt::format("the cost is at a minimum; the largest mismatch is {:.3g} tolerances", mismatch)};
  return {FitStatus::kNotConverged,
          fmt::format("stopped after {} iterations; the largest mismatch is {:.3g} tolerances",
                      result->iterations, mismatch)};
}

}  // namespace

std::string to_string(FitStatus status) {
  switch (status) {
    case FitStatus::kNotRun:
      return "not_run";
    case FitStatus::kConverged:
      return "converged";
    case FitStatus::kNotConverged:
      return "not_converged";
    case FitStatus::kDegenerate:
      return "degenerate";
    case FitStatus::kCancelled:
      return "cancelled";
    case FitStatus::kFailed:
      break;
  }
  return "failed";
}

bool within_tolerance(const FitProblem& problem, const FitResult& result, double share) {
  if (result.smooth_statistics.size() != Eigen::Index(problem.targets.size())) return false;
  for (std::size_t k = 0; k < problem.targets.size(); ++k) {
    const Target& target = problem.targets[k];
    if (!(std::abs(result.smooth_statistics[Eigen::Index(k)] - target.value) <= share * target.tolerance))
      return false;
  }
  return true;
}

std::string solver_version() { return CERES_VERSION_STRING; }

FitResult calibrate(const FitProblem& problem, const Eigen::VectorXd& start, const FitOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  FitResult result;
  result.white = start;
  result.coefficients = problem.prior.colour(start);
  const Eigen::VectorXd centre =
      options.prior == PriorMode::kNearStart ? start : Eigen::VectorXd::Zero(start.size()).eval();

  Eigen::VectorXd values;
  const double first_width = options.smoothing.front() * problem.focal_sigma;
  if (!FocusModel(problem, first_width, options.threads)(start, &values, nullptr)) {
    result.status = FitStatus::kDegenerate;
    result.message =
        "a focal statistic has no derivative at the start (all rays on one point, or a kernel wider than the "
        "spot): start "
        "from a draw instead of the perfect mirror";
    return result;
  }
  double cost = options.prior == PriorMode::kNearStart ? 0.0 : start.squaredNorm();
  const auto add_cost = [&cost](double value, const Target& target) {
    const double residual = (value - target.value) / target.tolerance;
    cost += residual * residual;
  };
  Eigen::Index at = 0;
  for (const Target& target : problem.targets) add_cost(values[at++], target);
  for (const Target& guide : problem.guides) add_cost(values[at++], guide);
  result.initial_cost = 0.5 * cost;

  FocusResiduals::Linearisation last;
  for (const double width : options.smoothing) {
    const Solve solve = solve_once(problem, centre, options, width, begin, &last, &result);
    result.status = solve.status;
    result.message = solve.message;
    if (solve.status == FitStatus::kFailed || solve.status == FitStatus::kCancelled) break;
  }
  result.coefficients = problem.prior.colour(result.white);
  result.smooth_statistics =
      last.values.head(std::min<Eigen::Index>(last.values.size(), problem.targets.size()));
  if (last.jacobian.size() > 0) fill_posterior(problem, last.jacobian, &result);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace aberfit
