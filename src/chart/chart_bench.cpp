#include "chart_bench.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/method/band_choice.h"

namespace aberfit::internal {
namespace {

constexpr int kFewest = 5, kMost = 51;  // repeats

double quantile(const std::vector<double>& sorted, double p) {
  const double at = p * double(sorted.size() - 1);
  const auto below = std::size_t(at);
  if (below + 1 >= sorted.size()) return sorted.back();
  return sorted[below] + (at - double(below)) * (sorted[below + 1] - sorted[below]);
}

// The layout is the caller's: by rays, or as `fit` has it.
ChartBench bench_of(const Task& task, const RunContext& context,
                    const std::function<Layout(const Task&, int threads)>& laid_out) {
  ChartBench bench{task, {}, {}, {}, {}, {}, {}, 0, 0, 1, {}};
  bench.threads = context.threads;
  bench.say = [context](const std::string& line) { context.say(line); };
  bench.say("targets");
  Layout layout = laid_out(task, bench.threads);
  bench.ground = std::move(layout.ground);
  bench.targets = std::move(layout.targets);
  bench.say("prior");
  TermPlan plan = plan_terms(task, bench.ground, task.terms);
  bench.terms = std::move(plan.terms);
  bench.prior = std::move(plan.prior);
  bench.coefficients = bench.prior.colour(draw_white(bench.prior.size(), task.fit.seed));
  bench.tolerance = std::numeric_limits<double>::infinity();
  for (const Target& target : bench.targets.fitted) {
    bench.statistics.push_back(target.statistic);
    bench.tolerance =
        std::min(bench.tolerance, target.tolerance / statistic_scale(target.statistic, target.value));
  }
  bench.smoothing = FitOptions().smoothing.back() * bench.ground.focal_sigma;
  return bench;
}

}  // namespace

ChartBench bench_of_rays(const Task& task, Theory theory, const RunContext& context) {
  return bench_of(task, context, [theory](const Task& of, int threads) {
    Layout layout{lay_groundwork(of, {theory, FocusModel::kRays}), {}};
    layout.targets = make_targets(of, layout.ground, threads);
    return layout;
  });
}

ChartBench bench_of_fit(const Task& task, const RunContext& context) {
  return bench_of(task, context, [](const Task& of, int threads) { return lay_out(of, threads); });
}

ChartTrace::ChartTrace(const ChartBench& bench, const TermSet& terms, PupilSample pupil, int threads)
    : bench_(bench),
      threads_(threads),
      pupil_(std::move(pupil)),
      surface_(terms, pupil_, OperatorOptions{threads, {}, {}}),
      nominal_(trace_nominal(bench.task.mirror, pupil_)) {}

ChartTrace::ChartTrace(const ChartBench& bench, const PupilOptions& pupil)
    : ChartTrace(bench, bench.terms, make_pupil(bench.task.aperture, pupil), bench.threads) {}

void ChartTrace::set_sizes(ChartRow* row) const {
  row->rays = pupil_.size();
  row->terms = surface_.terms().size();
  row->statistics = std::int64_t(bench_.statistics.size());
}

Eigen::VectorXd ChartTrace::exact(const Eigen::VectorXd& coefficients,
                                  const std::vector<Statistic>& statistics) {
  surface_.apply(coefficients, &field_);
  return exact_of(field_, statistics);
}

Eigen::VectorXd ChartTrace::exact_of(const SurfaceField& field, const std::vector<Statistic>& statistics) {
  trace(bench_.task.mirror, pupil_, field, threads_, &rays_);
  return evaluate_exact({rays_, nominal_, field.height, bench_.task.trace.centre}, statistics, threads_);
}

bool ChartTrace::smooth(const Eigen::VectorXd& coefficients, const std::vector<Statistic>& statistics,
                        double width, Eigen::VectorXd* values, Eigen::MatrixXd* jacobian) {
  surface_.apply(coefficients, &field_);
  trace(bench_.task.mirror, pupil_, field_, threads_, &rays_);
  const FocusInput input{rays_, nominal_, field_.height, bench_.task.trace.centre};
  if (!evaluate_smooth(input, statistics, width, threads_, &workspace_, values,
                       jacobian ? &gradients_ : nullptr))
    return false;
  if (!jacobian) return true;
  jacobian->resize(values->size(), coefficients.size());
  parallel_for(statistics.size(), threads_, [&](std::size_t k) {
    const StatisticGradient& gradient = gradients_[k];
    const auto row = Eigen::Index(k);
    if (gradient.d_height.size() > 0) {
      const Eigen::ArrayXd none = Eigen::ArrayXd::Zero(field_.size());
      jacobian->row(row) = surface_.apply_transpose(SurfaceField{gradient.d_height, none, none}).transpose();
    } else {
      const SurfaceField weights = trace_adjoint(bench_.task.mirror, pupil_, field_, gradient.rays);
      jacobian->row(row) = (gradient.rays.all_rays ? surface_.apply_transpose(weights)
                                                   : surface_.apply_transpose(gradient.rays.rays, weights))
                               .transpose();
    }
  });
  return jacobian->allFinite();
}

ChartTime measure_time(double budget, const std::function<void()>& run) {
  std::vector<double> seconds;
  const ChartClock clock(budget);
  do {
    const ChartClock one(0);
    run();
    seconds.push_back(one.elapsed());
    const int repeats = int(seconds.size());
    if (repeats >= kMost || (repeats >= kFewest && clock.elapsed() > 0.2 * budget)) break;
  } while (clock.elapsed() * (1 + 1.0 / double(seconds.size())) < budget);
  std::sort(seconds.begin(), seconds.end());
  return {quantile(seconds, 0.5), quantile(seconds, 0.25), quantile(seconds, 0.75), int(seconds.size())};
}

ChartFamily family_of(const std::string& name, const std::string& title, const std::string& error_of,
                      const std::string& timed, const ErrorLimit& limit) {
  return {name, title, error_of, timed, limit.value, limit.name, {}, "", ""};
}

ChartRow row_of(const std::string& method, const std::string& parameter, double value,
                const std::string& unit) {
  ChartRow row;
  row.method = method;
  row.parameter = parameter;
  row.value = value;
  row.unit = unit;
  return row;
}

void set_time(const ChartTime& time, ChartRow* row) {
  row->seconds = time.median;
  row->seconds_low = time.low;
  row->seconds_high = time.high;
  row->repeats = time.repeats;
}

void set_errors(const StatisticErrors& errors, const std::string& reference, double error_of_reference,
                ChartRow* row) {
  row->error = errors.worst;
  row->error_rms = errors.rms;
  row->reference = reference;
  row->error_of_reference = error_of_reference;
}

double statistic_scale(const Statistic& statistic, double reference) {
  return kind_of(statistic).dimension == Dimension::kFraction ? 1.0 : std::abs(reference);
}

StatisticErrors worst_and_rms(const std::vector<double>& errors) {
  if (errors.empty()) return {};
  StatisticErrors both{0};
  for (const double error : errors) {
    if (!std::isfinite(error)) return {};
    both.worst = std::max(both.worst, error);
    both.rms += error * error;
  }
  both.rms = std::sqrt(both.rms / double(errors.size()));
  return both;
}

StatisticErrors statistic_errors(const Eigen::VectorXd& values, const Eigen::VectorXd& reference,
                                 const std::vector<Statistic>& statistics) {
  std::vector<double> errors;
  for (Eigen::Index k = 0; k < reference.size(); ++k) {
    const double scale = statistic_scale(statistics[std::size_t(k)], reference[k]);
    if (!std::isfinite(reference[k]) || !(scale > 0)) continue;
    errors.push_back(std::abs(values[k] - reference[k]) / scale);
  }
  return worst_and_rms(errors);
}

std::vector<Target> in_light(std::vector<Target> targets) {
  std::erase_if(targets, [](const Target& target) {
    return !std::holds_alternative<EncircledEnergyRadius>(target.statistic);
  });
  return targets;
}

PupilOptions pupil_of_at_most(const Task& task, std::int64_t most) {
  PupilOptions pupil = task.trace.pupil;
  pupil.rays = std::min(rays_of(pupil), most);
  return pupil;
}

std::optional<PupilSample> try_pupil(const Aperture& aperture, const PupilOptions& options) {
  try {
    return make_pupil(aperture, options);
  } catch (const ComputationError&) {
    return std::nullopt;
  }
}

std::string name_of(PupilLayout layout) {
  constexpr const char* kNames[] = {"polar", "random", "sobol", "grid"};
  return kNames[std::size_t(layout)];
}

double mean_square_slope(const PupilSample& pupil, const SurfaceField& field) {
  return (pupil.weight * (field.slope_x.square() + field.slope_y.square())).sum();
}

}  // namespace aberfit::internal
