#include "aberfit/fit/calibrate.h"

#include <ceres/problem.h>
#include <ceres/solver.h>
#include <ceres/version.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "calibration_residuals.h"
#include "posterior.h"
#include "span_residuals.h"

namespace aberfit {
using namespace internal;

namespace {

// A coarse solve stops at this many tolerances and leaves the rest to the finer kernel. Its own smoothing,
// and the few rays that distinguish the two kernels, cause errors of that size.
constexpr double kCoarseStop = 3;
// Relative effect of one prior standard deviation on a statistic above which a step is not damped; see
// first_radius.
constexpr double kDamped = 1e-2;

// Residuals, in tolerances per prior standard deviation, at or below which rounding dominates.
constexpr double kStationary = 1e-6;

// Weight times xi - xi0 of one block.
class PriorResiduals : public ceres::CostFunction {
 public:
  PriorResiduals(Eigen::VectorXd centre, double weight) : centre_(std::move(centre)), weight_(weight) {
    set_num_residuals(int(centre_.size()));
    mutable_parameter_block_sizes()->push_back(int(centre_.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Index n = centre_.size();
    Eigen::Map<Eigen::VectorXd>(residuals, n) =
        weight_ * (Eigen::Map<const Eigen::VectorXd>(parameters[0], n) - centre_);
    if (jacobians && jacobians[0])
      Eigen::Map<Eigen::MatrixXd>(jacobians[0], n, n) = weight_ * Eigen::MatrixXd::Identity(n, n);
    return true;
  }

 private:
  Eigen::VectorXd centre_;
  double weight_;
};

// Largest residual of the targets and PSD bins, and of the guides over `guides_within` unless that is 0.
double worst_mismatch(const FitProblem& problem, const CalibrationResiduals& residuals,
                      double guides_within) {
  const Eigen::VectorXd& last = residuals.last().residuals;
  const auto targets = Eigen::Index(problem.targets.size()), guides = Eigen::Index(problem.guides.size());
  double worst = 0;
  for (Eigen::Index k = 0; k < last.size(); ++k) {
    const bool guide = k >= targets && k < targets + guides;
    if (!guide) worst = std::max(worst, std::abs(last[k]));
    if (guide && guides_within > 0) worst = std::max(worst, std::abs(last[k]) / guides_within);
  }
  return worst;
}

// Counts iterations, reports progress, accepts a cancellation, and ends a solve within tolerance.
class Watch : public ceres::IterationCallback {
 public:
  // step_by_step: every call of the solver ends after its first accepted step.
  Watch(const FitProblem& problem, const CalibrationResiduals& residuals, const FitOptions& options,
        double stop_at, int solve, int iterations_before, bool step_by_step,
        std::chrono::steady_clock::time_point begin)
      : problem_(problem),
        residuals_(residuals),
        options_(options),
        stop_at_(stop_at),
        solve_(solve),
        iterations_(iterations_before),
        step_by_step_(step_by_step),
        begin_(begin) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    const bool first = summary.iteration == 0;
    if (first && reported_) return ceres::SOLVER_CONTINUE;  // the point where the last call ended
    reported_ = true;
    iterations_ += first ? 0 : 1;
    ended_ = is_over(summary.cost);
    const bool stepped = step_by_step_ && !first && summary.step_is_successful;
    return ended_ || stepped ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }
  int iterations() const { return iterations_; }
  bool ended() const { return ended_; }
  bool cancelled() const { return cancelled_; }

 private:
  bool is_over(double cost) {
    const double mismatch = worst_mismatch(problem_, residuals_, options_.guides_within);
    if (options_.progress) {
      const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin_;
      cancelled_ = !options_.progress({iterations_, cost, mismatch, elapsed.count(), solve_});
    }
    if (cancelled_ || mismatch <= stop_at_) return true;
    // All tolerances are met but `stop_at` is not near: the rest is creeping along the prior.
    if (mismatch < (1 - kWorthwhile) * best_) {
      best_ = mismatch;
      since_best_ = 0;
      return false;
    }
    return ++since_best_ >= kPatience && mismatch <= 1;
  }

  const FitProblem& problem_;
  const CalibrationResiduals& residuals_;
  const FitOptions& options_;
  double stop_at_;
  int solve_;
  int iterations_;
  bool step_by_step_;
  std::chrono::steady_clock::time_point begin_;
  bool reported_ = false, ended_ = false, cancelled_ = false;
  static constexpr double kWorthwhile = 0.1;  // fraction by which the worst mismatch has to fall
  static constexpr int kPatience = 5;         // in this many iterations
  double best_ = std::numeric_limits<double>::infinity();
  int since_best_ = 0;
};

// First trust region radius, one over the damping of a squared singular value of the Jacobian. Without
// damping, the first steps go far along combinations of statistics that the coefficients hardly affect, such
// as the difference of neighbouring radii. The linearisation there is mostly sampling noise.
double first_radius(const FitProblem& problem) {
  double tolerance = std::numeric_limits<double>::infinity();
  for (const Target& target : problem.targets)
    if (target.relative_to() > 0) tolerance = std::min(tolerance, target.tolerance / target.relative_to());
  if (problem.spectrum && problem.spectrum_tolerance.size() > 0)
    tolerance = std::min(tolerance, problem.spectrum_tolerance.minCoeff());
  return std::isfinite(tolerance) ? std::pow(tolerance / kDamped, 2) : 1;
}

// The cost functions of a problem stay with their owner.
ceres::Problem::Options borrowing() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  return options;
}

ceres::Solver::Options solver_options(const FitProblem& problem) {
  ceres::Solver::Options options;
  options.jacobi_scaling = false;  // the problem is already whitened
  options.function_tolerance = 1e-9;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-10;
  options.logging_type = ceres::SILENT;
  // All directions have the same damping, because they turn at every step and the prior has scaled them.
  options.min_lm_diagonal = options.max_lm_diagonal = 1;
  options.initial_trust_region_radius = first_radius(problem);
  return options;
}

// Solves for all white coordinates with bounds. Changes `white`.
ceres::Solver::Summary solve_bounded(CalibrationResiduals* residuals, const Eigen::VectorXd& centre,
                                     const FitOptions& how, ceres::Solver::Options options,
                                     Eigen::VectorXd* white) {
  // For identity plus low rank, conjugate gradients need about as many steps as there are statistics.
  options.linear_solver_type = ceres::CGNR;
  options.preconditioner_type = ceres::IDENTITY;
  options.max_linear_solver_iterations = 300;
  options.eta = 1e-3;  // a step costs far less than the Jacobian, so it is solved accurately

  ceres::Problem ceres_problem(borrowing());
  std::vector<std::unique_ptr<PriorResiduals>> priors;
  std::vector<double*> blocks;
  Eigen::Index at = 0;
  for (const int size : residuals->parameter_block_sizes()) {
    blocks.push_back(white->data() + at);
    ceres_problem.AddParameterBlock(blocks.back(), size);
    priors.push_back(std::make_unique<PriorResiduals>(centre.segment(at, size), how.prior_weight));
    ceres_problem.AddResidualBlock(priors.back().get(), nullptr, blocks.back());
    for (int i = 0; i < size; ++i) {
      ceres_problem.SetParameterLowerBound(blocks.back(), i, -how.bound);
      ceres_problem.SetParameterUpperBound(blocks.back(), i, how.bound);
    }
    at += size;
  }
  ceres_problem.AddResidualBlock(residuals, nullptr, blocks);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  return summary;
}

// Levenberg-Marquardt in the span of the residuals' gradients, which changes at every step. Changes `white`.
// The gradients span the space at the surface, and the solver damps until a step lowers the cost. The solve
// continues there with that damping, until `watch` or the solver's tolerances end it. Each accepted surface
// is evaluated and linearised once; a repeated request is answered from memory.
ceres::Solver::Summary solve_in_spans(const FitProblem& problem, const CalibrationResiduals& residuals,
                                      const Eigen::VectorXd& centre, const FitOptions& how,
                                      ceres::Solver::Options options, const Watch& watch,
                                      Eigen::VectorXd* white) {
  options.linear_solver_type = ceres::DENSE_QR;
  bool bends = false;
  ceres::Solver::Summary summary;
  summary.message = "a statistic has no derivative at the start";
  Eigen::VectorXd here(residuals.num_residuals());
  if (!residuals.evaluate(*white, true, here.data())) return summary;
  for (;;) {
    SpanResiduals small(residuals, centre, how.prior_weight, 1 / options.initial_trust_region_radius, bends);
    Eigen::VectorXd y = small.start();
    ceres::Problem ceres_problem(borrowing());
    ceres_problem.AddResidualBlock(&small, nullptr, y.data());
    options.max_num_iterations = std::max(0, how.max_iterations - watch.iterations());
    ceres::Solve(options, &ceres_problem, &summary);
    *white = residuals.last().white;
    if (watch.ended() || summary.termination_type != ceres::USER_SUCCESS) return summary;
    options.initial_trust_region_radius = summary.iterations.back().trust_region_radius;
    // Most steps from the start fail because whole radii are wrong, not because of curvature; they are
    // straight.
    bends = how.accelerate && smooth_by_itself(problem.light.model);
  }
}

// Tolerances beyond which the solver's own convergence is no solution. Prior and targets that oppose each
// other hold a fit at a few of them.
constexpr double kFarOff = 10;

struct Solve {
  FitStatus status;
  std::string message;
};

// One solve from result->white, which it changes, to `stop_at` times the tolerances.
Solve solve_once(const FitProblem& problem, CalibrationResiduals& residuals, const Eigen::VectorXd& centre,
                 const FitOptions& options, double stop_at, int number,
                 std::chrono::steady_clock::time_point begin, FitResult* result) {
  const bool bounded = options.bound > 0;
  Watch watch(problem, residuals, options, stop_at, number, result->iterations, !bounded, begin);
  ceres::Solver::Options ceres_options = solver_options(problem);
  ceres_options.max_num_iterations = std::max(0, options.max_iterations - result->iterations);
  ceres_options.callbacks.push_back(&watch);
  const ceres::Solver::Summary summary =
      bounded ? solve_bounded(&residuals, centre, options, ceres_options, &result->white)
              : solve_in_spans(problem, residuals, centre, options, ceres_options, watch, &result->white);

  result->iterations = watch.iterations();
  result->evaluations = residuals.evaluations();
  result->final_cost = summary.final_cost;
  result->out_of_iterations = summary.termination_type == ceres::NO_CONVERGENCE;
  if (watch.cancelled()) return {FitStatus::kCancelled, "cancelled"};
  if (!summary.IsSolutionUsable() || residuals.last().white.size() == 0)
    return {FitStatus::kFailed, "the solver failed: " + summary.message};
  const double mismatch = worst_mismatch(problem, residuals, 0);
  if (mismatch <= std::max(1.0, options.stop_at))
    return {FitStatus::kConverged, fmt::format("every target is met within {:.2g} tolerances", mismatch)};
  if (summary.termination_type == ceres::CONVERGENCE && mismatch > kFarOff)
    return {FitStatus::kNotConverged,
            fmt::format("no step lowers the cost; the largest mismatch is {:.3g} tolerances. Try another "
                        "start or more terms, or look for targets that contradict each other",
                        mismatch)};
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

// Half the squares of the target residuals at the start, or the reason why a block has no derivative there.
struct StartCost {
  double value = 0;
  std::string trouble;
};
StartCost start_cost(const FitProblem& problem, const CalibrationResiduals& residuals,
                     const Eigen::VectorXd& start) {
  StartCost cost;
  const FocusResiduals* focus = residuals.focus();
  const SpectrumResiduals* spectrum = residuals.spectrum();
  if (!focus && !spectrum) cost.trouble = "there is nothing to fit, neither targets nor guides nor PSD bins";
  WhiteResiduals::Linearisation here;
  if (focus) {
    // The spot of a perfect mirror exists, but its pattern is at an optimum: to first order nothing changes.
    const bool perfect = smooth_by_itself(problem.light.model) && start.isZero(0);
    if (!focus->linearise(start, perfect, &here))
      cost.trouble =
          fmt::format("at the start, {}{}", focus->forward().trouble(),
                      start.isZero(0) ? "; start from a realisation instead of the perfect mirror" : "");
    else if (perfect && here.jacobian.cwiseAbs().maxCoeff() < kStationary)
      cost.trouble =
          "no statistic changes to first order about the perfect mirror; start from a realisation instead";
    else
      cost.trouble = focus->forward().unreachable(problem.targets);
    if (cost.trouble.empty()) cost.value += 0.5 * here.residuals.squaredNorm();
  }
  if (spectrum && cost.trouble.empty()) {
    if (spectrum->linearise(start, true, &here))
      cost.value += 0.5 * here.residuals.squaredNorm();
    else
      cost.trouble =
          "a PSD bin of the surface is zero at the start, so its logarithm has no value. Start from a "
          "realisation instead of the perfect mirror, and request only bins that the terms reach";
  }
  return cost;
}

}  // namespace

std::string to_string(FitStatus status) {
  // The order is that of the enum.
  constexpr const char* kWords[] = {"not_run",    "converged", "not_converged",
                                    "degenerate", "cancelled", "failed"};
  return kWords[int(status)];
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
  result.operator_choice = problem.light.surface.choice();
  const Eigen::VectorXd centre =
      options.prior == PriorMode::kNearStart ? start : Eigen::VectorXd::Zero(start.size()).eval();

  // A model that smooths by itself needs no coarse kernel first.
  const std::size_t first = smooth_by_itself(problem.light.model) ? options.smoothing.size() - 1 : 0;
  CalibrationResiduals residuals(problem, options.smoothing[first] * problem.focal_sigma, options.threads);
  const StartCost cost = start_cost(problem, residuals, start);
  if (!cost.trouble.empty()) {
    result.status = FitStatus::kDegenerate;
    result.message = cost.trouble;
    return result;
  }
  result.initial_cost =
      cost.value + (options.prior == PriorMode::kNearStart ? 0.0 : 0.5 * start.squaredNorm());

  for (std::size_t i = first; i < options.smoothing.size(); ++i) {
    const bool coarse = i + 1 < options.smoothing.size();
    if (i > first) residuals.set_width(options.smoothing[i] * problem.focal_sigma);
    const double stop_at = coarse ? std::max(options.stop_at, kCoarseStop) : options.stop_at;
    const Solve solve = solve_once(problem, residuals, centre, options, stop_at, int(i), begin, &result);
    result.status = solve.status;
    result.message = solve.message;
    if (solve.status == FitStatus::kFailed || solve.status == FitStatus::kCancelled) break;
    if (!residuals.focus()) break;  // the spectrum has no smoothing
  }
  result.coefficients = problem.prior.colour(result.white);
  const WhiteResiduals::Linearisation& last = residuals.last();
  if (last.values.size() > 0) {
    result.smooth_statistics = last.values.head(Eigen::Index(problem.targets.size()));
    if (problem.spectrum) result.spectrum = last.values.tail(problem.spectrum->bins());
    fill_posterior(problem, last.jacobian, &result);
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace aberfit
