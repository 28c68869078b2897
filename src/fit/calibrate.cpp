#include "aberfit/fit/calibrate.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

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

// The residual blocks of one solve: focal statistics, PSD bins, or both.
struct Blocks {
  std::unique_ptr<FocusResiduals> focus;
  std::unique_ptr<SpectrumResiduals> spectrum;

  Blocks(const FitProblem& problem, double width, int threads) {
    if (!problem.targets.empty() || !problem.guides.empty())
      focus = std::make_unique<FocusResiduals>(problem, width, threads);
    if (problem.spectrum && problem.spectrum->bins() > 0)
      spectrum = std::make_unique<SpectrumResiduals>(problem);
  }
  bool empty() const { return !focus && !spectrum; }
  int evaluations() const {
    return std::max(focus ? focus->evaluations() : 0, spectrum ? spectrum->evaluations() : 0);
  }
};

// Values and derivatives of all blocks at one point; empty where a block is absent or had none.
struct LastPoint {
  WhiteResiduals::Linearisation focus, spectrum;

  LastPoint() = default;
  explicit LastPoint(const Blocks& blocks) {
    if (blocks.focus) focus = blocks.focus->last();
    if (blocks.spectrum) spectrum = blocks.spectrum->last();
  }
  Eigen::MatrixXd jacobian() const {
    Eigen::MatrixXd all(focus.jacobian.rows() + spectrum.jacobian.rows(),
                        std::max(focus.jacobian.cols(), spectrum.jacobian.cols()));
    if (focus.jacobian.rows() > 0) all.topRows(focus.jacobian.rows()) = focus.jacobian;
    if (spectrum.jacobian.rows() > 0) all.bottomRows(spectrum.jacobian.rows()) = spectrum.jacobian;
    return all;
  }
};

bool complete(const Blocks& blocks, const LastPoint& last) {
  return (!blocks.focus || last.focus.residuals.size() > 0) &&
         (!blocks.spectrum || last.spectrum.residuals.size() > 0);
}

// Largest residual of the targets and PSD bins; the guides behind the targets do not count.
double worst_mismatch(const FitProblem& problem, const Blocks& blocks) {
  const auto largest = [](const auto& residuals) {
    return residuals.size() == 0 ? 0.0 : residuals.cwiseAbs().maxCoeff();
  };
  double worst = 0;
  if (blocks.focus) {
    const Eigen::VectorXd& residuals = blocks.focus->last().residuals;
    worst = largest(
        residuals.head(std::min<Eigen::Index>(residuals.size(), Eigen::Index(problem.targets.size()))));
  }
  if (blocks.spectrum) worst = std::max(worst, largest(blocks.spectrum->last().residuals));
  return worst;
}

// Ends a solve as soon as every statistic is within tolerance, reports progress, and hears a wish to cancel.
class Watch : public ceres::IterationCallback {
 public:
  Watch(const FitProblem& problem, const Blocks& blocks, const FitOptions& options, int iterations_before,
        std::chrono::steady_clock::time_point begin)
      : problem_(problem),
        blocks_(blocks),
        options_(options),
        iterations_before_(iterations_before),
        begin_(begin) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    const double mismatch = worst_mismatch(problem_, blocks_);
    if (options_.progress) {
      const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin_;
      if (!options_.progress(
              {iterations_before_ + summary.iteration, summary.cost, mismatch, elapsed.count()})) {
        cancelled_ = true;
        return ceres::SOLVER_ABORT;
      }
    }
    if (mismatch <= options_.stop_at) return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    // All tolerances met but `stop_at` not in sight: the rest is creeping along the prior.
    if (mismatch < (1 - kWorthwhile) * best_) {
      best_ = mismatch;
      since_best_ = 0;
    } else if (++since_best_ >= kPatience && mismatch <= 1) {
      return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    }
    return ceres::SOLVER_CONTINUE;
  }
  bool cancelled() const { return cancelled_; }

 private:
  const FitProblem& problem_;
  const Blocks& blocks_;
  const FitOptions& options_;
  int iterations_before_;
  std::chrono::steady_clock::time_point begin_;
  bool cancelled_ = false;
  static constexpr double kWorthwhile = 0.1;  // share by which the worst mismatch has to fall
  static constexpr int kPatience = 5;         // iterations in which it has to
  double best_ = std::numeric_limits<double>::infinity();
  int since_best_ = 0;
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
                 double width, std::chrono::steady_clock::time_point begin, LastPoint* last,
                 FitResult* result) {
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  const Blocks residuals(problem, width * problem.focal_sigma, options.threads);
  std::vector<std::unique_ptr<PriorResiduals>> priors;
  ceres::Problem ceres_problem(ownership);
  std::vector<double*> blocks;
  Eigen::Index at = 0;
  for (const int size : white_block_sizes(problem.prior.size())) {
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
  if (residuals.focus) ceres_problem.AddResidualBlock(residuals.focus.get(), nullptr, blocks);
  if (residuals.spectrum) ceres_problem.AddResidualBlock(residuals.spectrum.get(), nullptr, blocks);

  Watch watch(problem, residuals, options, result->iterations, begin);
  ceres::Solver::Options ceres_options =
      solver_options(std::max(0, options.max_iterations - result->iterations));
  ceres_options.callbacks.push_back(&watch);
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options, &ceres_problem, &summary);

  result->iterations += std::max(0, int(summary.iterations.size()) - 1);
  result->evaluations += residuals.evaluations();
  result->final_cost = summary.final_cost;
  *last = LastPoint(residuals);
  if (watch.cancelled()) return {FitStatus::kCancelled, "cancelled"};
  if (!summary.IsSolutionUsable() || !complete(residuals, *last))
    return {FitStatus::kFailed, "the solver failed: " + summary.message};
  const double mismatch = worst_mismatch(problem, residuals);
  if (mismatch <= std::max(1.0, options.stop_at))
    return {FitStatus::kConverged, fmt::format("every target is within {:.2g} of its tolerance", mismatch)};
  if (summary.termination_type == ceres::CONVERGENCE)
    return {FitStatus::kConverged,
            fmt::format("the cost is at a minimum; the largest mismatch is {:.3g} tolerances", mismatch)};
  return {FitStatus::kNotConverged,
          fmt::format("stopped after {} iterations; the largest mismatch is {:.3g} tolerances",
                      result->iterations, mismatch)};
}

void check_spectrum(const FitProblem& problem) {
  const Eigen::Index bins = problem.spectrum ? problem.spectrum->bins() : 0;
  const auto check = [bins](const Eigen::VectorXd& values, const char* name) {
    if (values.size() != bins || !values.allFinite() || !(values.array() > 0).all())
      throw std::invalid_argument(
          fmt::format("FitProblem: {} needs one positive number for each of {} PSD bins", name, bins));
  };
  check(problem.spectrum_target, "spectrum_target");
  check(problem.spectrum_tolerance, "spectrum_tolerance");
}

// Half the squares of the target residuals at the start; why not, where a block has no derivative there.
struct StartCost {
  double value = 0;
  std::string trouble;
};
StartCost start_cost(const FitProblem& problem, const Eigen::VectorXd& start, double width, int threads) {
  const Blocks blocks(problem, width, threads);
  StartCost cost;
  WhiteResiduals::Linearisation here;
  if (blocks.empty()) cost.trouble = "there is nothing to fit: neither targets nor guides nor PSD bins";
  if (blocks.focus) {
    if (blocks.focus->linearise(start, false, &here))
      cost.value += 0.5 * here.residuals.squaredNorm();
    else
      cost.trouble =
          "a focal statistic has no derivative at the start (all rays on one point, or a kernel wider than "
          "the spot): start from a draw instead of the perfect mirror";
  }
  if (blocks.spectrum) {
    if (blocks.spectrum->linearise(start, true, &here))
      cost.value += 0.5 * here.residuals.squaredNorm();
    else
      cost.trouble =
          "a PSD bin of the surface is zero at the start, so that its logarithm has no value: start from a "
          "draw instead of the perfect mirror, and ask only for bins that the terms reach";
  }
  return cost;
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
  const Eigen::Index bins = problem.spectrum ? problem.spectrum->bins() : 0;
  if (result.smooth_statistics.size() != Eigen::Index(problem.targets.size()) ||
      result.spectrum.size() != bins)
    return false;
  for (Eigen::Index b = 0; b < bins; ++b)
    if (!(std::abs(std::log(result.spectrum[b] / problem.spectrum_target[b])) <=
          share * problem.spectrum_tolerance[b]))
      return false;
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
  check_spectrum(problem);
  FitResult result;
  result.white = start;
  result.coefficients = problem.prior.colour(start);
  const Eigen::VectorXd centre =
      options.prior == PriorMode::kNearStart ? start : Eigen::VectorXd::Zero(start.size()).eval();

  const double first_width = options.smoothing.front() * problem.focal_sigma;
  const StartCost cost = start_cost(problem, start, first_width, options.threads);
  if (!cost.trouble.empty()) {
    result.status = FitStatus::kDegenerate;
    result.message = cost.trouble;
    return result;
  }
  result.initial_cost =
      cost.value + (options.prior == PriorMode::kNearStart ? 0.0 : 0.5 * start.squaredNorm());

  LastPoint last;
  for (const double width : options.smoothing) {
    const Solve solve = solve_once(problem, centre, options, width, begin, &last, &result);
    result.status = solve.status;
    result.message = solve.message;
    if (solve.status == FitStatus::kFailed || solve.status == FitStatus::kCancelled) break;
    if (problem.targets.empty() && problem.guides.empty()) break;  // the spectrum knows no smoothing
  }
  result.coefficients = problem.prior.colour(result.white);
  result.smooth_statistics =
      last.focus.values.head(std::min<Eigen::Index>(last.focus.values.size(), problem.targets.size()));
  result.spectrum = last.spectrum.values;
  if (const Eigen::MatrixXd jacobian = last.jacobian(); jacobian.size() > 0)
    fill_posterior(problem, jacobian, &result);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace aberfit
