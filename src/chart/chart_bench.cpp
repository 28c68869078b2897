#include "chart_bench.h"

#include <algorithm>
#include <cmath>

#include "aberfit/chart/check.h"
#include "aberfit/method/band_choice.h"
#include "aberfit/method/plan.h"

namespace aberfit::internal {
namespace {

double quantile(const std::vector<double>& sorted, double p) {
  const double at = p * double(sorted.size() - 1);
  const auto below = std::size_t(at);
  if (below + 1 >= sorted.size()) return sorted.back();
  return sorted[below] + (at - double(below)) * (sorted[below + 1] - sorted[below]);
}

}  // namespace

ChartBench::ChartBench(const Task& of, const RunContext& context) : task(of), threads(context.threads) {
  say = [context](const std::string& line) {
    context.stop_if_asked();
    context.say(line);
  };
  say("targets");
  Layout layout = lay_out(task, threads);
  ground = std::move(layout.ground);
  targets = std::move(layout.targets);
  say("prior");
  TermPlan plan = plan_terms(task, ground, first_set(task, ground));
  terms = std::move(plan.terms);
  coefficients = plan.prior.colour(draw_white(plan.prior.size(), task.fit.seed));
}

ChartTime measure_time(double budget, const std::function<void()>& run) {
  std::vector<double> seconds;
  const ChartClock clock(budget);
  do {
    const ChartClock one(0);
    run();
    seconds.push_back(one.elapsed());
    if (seconds.size() >= 5 && clock.elapsed() > 0.2 * budget) break;
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

void set_errors(const std::vector<double>& errors, const std::string& reference, double error_of_reference,
                ChartRow* row) {
  double worst = errors.empty() ? std::nan("") : 0, square = worst;
  for (const double error : errors) {
    worst = std::isfinite(error) ? std::max(error, worst) : std::nan("");
    if (std::isnan(worst)) break;
    square += error * error;
  }
  row->error = worst;
  row->error_rms = std::isnan(worst) ? worst : std::sqrt(square / double(errors.size()));
  row->reference = reference;
  row->error_of_reference = error_of_reference;
}

std::vector<Target> in_light(std::vector<Target> targets) {
  std::erase_if(targets, [](const Target& target) {
    return !std::holds_alternative<EncircledEnergyRadius>(target.statistic);
  });
  return targets;
}

}  // namespace aberfit::internal
