#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/chart/chart.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/instruction_set.h"
#include "chart_families.h"

namespace aberfit {
using namespace internal;

namespace {

// Shares of the budget; they add up to one.
constexpr double kTheories = 0.01, kModels = 0.12, kFits = 0.22, kBands = 0.22, kPupils = 0.11,
                 kNormals = 0.07, kOperators = 0.07, kDerivatives = 0.08, kOrders = 0.04, kModes = 0.04,
                 kSmoothing = 0.02;

}  // namespace

Chart make_chart(const Task& task, double budget, const RunContext& context) {
  const ChartClock clock(budget);
  // The methods compared here are those of rays, whatever the scene needs.
  const Theory theory = task.target.theory == Theory::kRays ? Theory::kRays : Theory::kGeometric;
  const Task of_rays = seen_by_rays(task);
  const ChartBench bench = bench_of_rays(of_rays, theory, context);
  const PupilSample few = make_pupil(task.aperture, pupil_of_at_most(task, 1024));
  SurfaceField surface;
  SurfaceOperator(bench.terms, few, OperatorOptions{bench.threads, {}, {}})
      .apply(bench.coefficients, &surface);
  if (!(surface.slope_x.abs().maxCoeff() > 0))
    throw ComputationError(
        "the draw that a chart is made on is flat: its statistics have nothing to be wrong about");

  Chart chart;
  if (const auto& choice = bench.ground.use.choice; choice && choice->model != FocusModel::kRays)
    chart.warnings.push_back(
        {"rays-not-valid",
         fmt::format("this scene needs {}: from the pupils on, what is charted are the methods of rays",
                     to_string(choice->model))});
  chart.instruction_set = to_string(best_instruction_set());
  chart.threads = bench.threads;
  chart.budget_seconds = budget;
  const auto append = [&chart](std::vector<ChartFamily> families) {
    for (ChartFamily& family : families) {
      for (ChartRow& row : family.rows) row.family = family.name;
      mark_rows(&family);
      chart.families.push_back(std::move(family));
    }
  };
  // What a user asks first: which model, and what a whole fit takes with it. The kernels come second.
  const ChartBench as_is = bench_of_fit(task, context);
  append({chart_theories(as_is, kTheories * budget)});
  append({chart_models(as_is, kModels * budget)});
  append({chart_fits(as_is, kFits * budget)});
  append({chart_bands(as_is, kBands * budget)});
  append({chart_pupils(bench, kPupils * budget)});
  append(chart_normals(bench, kNormals * budget));
  append(chart_operators(bench, kOperators * budget));
  append({chart_derivatives(bench, kDerivatives * budget)});
  append({chart_orders(bench, kOrders * budget)});
  append({chart_modes(bench, kModes * budget)});
  append({chart_smoothing(bench, kSmoothing * budget)});
  chart.step_law = step_law(bench);
  chart.seconds = clock.elapsed();
  return chart;
}

}  // namespace aberfit
