#include "aberfit/chart/chart.h"
#include "aberfit/core/instruction_set.h"
#include "chart_bench.h"

namespace aberfit {
using namespace internal;

Chart make_chart(const Task& task, double budget, const RunContext& context) {
  const ChartClock clock(budget);
  const ChartBench bench(task, context);
  Chart chart;
  chart.instruction_set = to_string(best_instruction_set());
  chart.threads = bench.threads;
  chart.budget_seconds = budget;
  const auto append = [&chart](ChartFamily family) {
    for (ChartRow& row : family.rows) row.family = family.name;
    mark_rows(&family);
    chart.families.push_back(std::move(family));
  };
  // The most important question comes first: which model. A theory takes milliseconds, models a fifth of the
  // time, whole fits half of the rest, and cuts what is left.
  append(chart_theories(bench, 0.01 * budget));
  append(chart_models(bench, 0.2 * budget));
  append(chart_fits(bench, 0.5 * clock.left()));
  append(chart_bands(bench, clock.left()));
  chart.seconds = clock.elapsed();
  return chart;
}

}  // namespace aberfit
