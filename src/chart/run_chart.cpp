#include "aberfit/chart/run_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/core/errors.h"
#include "aberfit/core/instruction_set.h"
#include "aberfit/study/read_study.h"
#include "chart_families.h"
#include "aberfit/chart/cost_model.h"

namespace aberfit {
namespace {

// Shares of the budget. The fit's own stages first: `check` needs them most.
constexpr double kRates = 0.18, kPupils = 0.22, kNormals = 0.12, kOperators = 0.12, kDerivatives = 0.14,
                 kOrders = 0.08, kModes = 0.1, kSmoothing = 0.04;

}  // namespace

nlohmann::ordered_json run_chart(const Task& task, const RunOptions& options, std::string* table) {
  if (task.target.map)
    throw InputError(task.path, "/target/map", "a study of a map",
                     "statistics as targets: a map is fitted by linear least squares, which is exact, and "
                     "`aberfit check` predicts its cost");
  const double budget = options.chart_seconds;
  const ChartClock clock(budget);
  // The methods compared here are those of rays, whatever the scene needs.
  Study rays = study;
  rays.trace.model = FocusModel::kRays;
  if (task.target.theory != Theory::kRays) rays.target.theory = Theory::kGeometric;
  const ChartBench bench = make_chart_bench(rays, options);
  const SurfaceField surface = [&] {
    SurfaceField field;
    const PupilSample few = make_pupil(task.aperture, pupil_of_at_most(task, 1024));
    SurfaceOperator(bench.terms, few, OperatorOptions{bench.threads, {}, {}})
        .apply(bench.coefficients, &field);
    return field;
  }();
  if (!(surface.slope_x.abs().maxCoeff() > 0))
    throw ComputationError(
        "the draw that a chart is made on is flat: its statistics have nothing to be wrong about");

  Chart chart;
  if (const auto& choice = bench.scene.use.choice; choice && choice->model != FocusModel::kRays)
    chart.warnings.push_back(
        {"rays-not-valid", fmt::format("this scene needs {}: what is charted are the methods of rays",
                                       to_string(choice->model))});
  chart.study = resolved_study(task);
  chart.title = task.title;
  chart.instruction_set = to_string(best_instruction_set());
  chart.budget_seconds = budget;
  chart.rates = to_json(measure_rates(bench, kRates * budget));
  const auto append = [&chart](std::vector<ChartFamily> families) {
    for (ChartFamily& family : families) chart.families.push_back(std::move(family));
  };
  append({chart_pupils(bench, kPupils * budget)});
  append(chart_normals(bench, kNormals * budget));
  append(chart_operators(bench, kOperators * budget));
  append({chart_derivatives(bench, kDerivatives * budget)});
  append({chart_orders(bench, kOrders * budget)});
  append({chart_modes(bench, kModes * budget)});
  append({chart_smoothing(bench, kSmoothing * budget)});
  chart.step_law = step_law(bench);
  chart.seconds = clock.elapsed();
  chart.provenance = make_provenance(task.fit.seed, bench.threads);
  chart.provenance.libraries["ceres"] = solver_version();

  if (!options.output_directory.empty()) {
    bench.say("chart: files");
    if (options.plots && task.output.plots)
      write_chart_plots(chart, options.output_directory, &chart.warnings);
    const std::string folder = options.output_directory + "/";
    write_file(folder + "chart.csv", chart_csv(chart));
    write_file(folder + "summary.txt", summary_table(chart));
    // Last, so that a chart.json always has its companions beside it.
    write_file(folder + "chart.json", to_json(chart).dump(2) + "\n");
  }
  if (table) *table = summary_table(chart);
  return to_json(chart);
}

}  // namespace aberfit
