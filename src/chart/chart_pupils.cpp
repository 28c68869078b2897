#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "chart_families.h"

namespace aberfit::internal {
namespace {

constexpr std::int64_t kFewestRays = 1024, kMostRays = 1 << 20;
constexpr int kFactor = 4;
// Everything that is held per ray while a statistic is evaluated, and per ray and plane: bounds the reference
// to about 1.5 GB.
constexpr double kBytesPerRay = 200, kBytesPerPlane = 16, kMemory = 1.5e9;

double planes_of(const std::vector<Statistic>& statistics) {
  std::set<double> planes = {0};
  for (const Statistic& statistic : statistics)
    if (const auto* ee = std::get_if<EncircledEnergyRadius>(&statistic)) planes.insert(ee->dz);
  return double(planes.size());
}

// Those that exist for the aperture, the finest first: polar, else Sobol.
std::vector<PupilLayout> layouts_of(const Task& task) {
  std::vector<PupilLayout> layouts;
  for (const PupilLayout layout :
       {PupilLayout::kPolar, PupilLayout::kSobol, PupilLayout::kGrid, PupilLayout::kRandom})
    if (try_pupil(task.aperture, {layout, kFewestRays, task.trace.pupil.seed})) layouts.push_back(layout);
  return layouts;
}

ChartTrace trace_of(const ChartBench& bench, PupilLayout layout, std::int64_t rays) {
  return ChartTrace(bench, PupilOptions{layout, rays, bench.task.trace.pupil.seed});
}

// How many rays the budget allows.
struct RayBudget {
  double per_ray = 0;        // [s]
  double affordable = 0;     // rays
  std::int64_t largest = 0;  // count that is tried with every layout
};

// The reference costs four times the largest count, every layout about three times it (a third more for the
// smaller counts, and repeats).
RayBudget ray_budget(const ChartBench& bench, const std::vector<PupilLayout>& layouts, double seconds) {
  constexpr std::int64_t kProbe = 16384;
  RayBudget budget;
  ChartTrace probe = trace_of(bench, layouts.front(), kProbe);
  probe.exact();  // memory and caches
  budget.per_ray = measure_time(0.02 * seconds, [&] { probe.exact(); }).median / double(kProbe);
  budget.affordable = seconds / (budget.per_ray * (4 + 2.0 * double(layouts.size())));
  const double held =
      kMemory / (kBytesPerRay + kBytesPerPlane * planes_of(bench.statistics)) / double(kFactor);
  budget.largest = kFewestRays * kFactor * kFactor;
  while (budget.largest * kFactor <= kMostRays &&
         double(budget.largest) * kFactor <= std::min(budget.affordable, held))
    budget.largest *= kFactor;
  return budget;
}

// Powers of kFactor up to the largest, and the study's own count where its layout can afford it.
std::set<std::int64_t> ray_counts(PupilLayout layout, const Task& task, const RayBudget& budget) {
  const std::int64_t today = rays_of(task.trace.pupil);
  std::set<std::int64_t> counts;
  for (std::int64_t rays = kFewestRays; rays <= budget.largest; rays *= kFactor) counts.insert(rays);
  if (layout == layout_of(task.aperture, task.trace.pupil) &&
      double(today) <= std::max(2.0 * budget.affordable, 1e5))
    counts.insert(today);
  return counts;
}

// Error against `truth` and time within `budget` [s] of a layout with so many rays; how far the truth is to
// be trusted is not known yet.
ChartRow measured_row(const ChartBench& bench, PupilLayout layout, std::int64_t rays,
                      const Eigen::VectorXd& truth, const std::string& reference, double budget) {
  ChartTrace at = trace_of(bench, layout, rays);
  Eigen::VectorXd values;
  ChartRow row = row_of(name_of(layout), "rays", double(rays));
  set_time(measure_time(budget, [&] { values = at.exact(); }), &row);
  set_errors(statistic_errors(values, truth, bench.statistics), reference, std::nan(""), &row);
  at.set_sizes(&row);
  const PupilOptions& today = bench.task.trace.pupil;
  row.is_default = layout == layout_of(bench.task.aperture, today) && rays == rays_of(today);
  return row;
}

// Any layout gains at least 1/sqrt(4) from four times the rays, so the reference is off by no more than half
// of what its own layout was at the largest count.
double error_of_reference(const std::vector<ChartRow>& rows, PupilLayout finest, std::int64_t largest) {
  double best = std::numeric_limits<double>::infinity();
  for (const ChartRow& row : rows)
    if (row.method == name_of(finest) && row.value == double(largest)) best = row.error;
  return 0.5 * best;
}

}  // namespace

ChartFamily chart_pupils(const ChartBench& bench, double seconds) {
  const Task& task = bench.task;
  ChartFamily family = family_of("pupil", "Pupil layouts and ray counts",
                                 "largest relative error of the statistics of one surface",
                                 "terms, rays and exact statistics", bench.margin());
  const std::vector<PupilLayout> layouts = layouts_of(task);
  const RayBudget budget = ray_budget(bench, layouts, seconds);

  bench.say("chart: pupils, reference");
  const PupilLayout finest = layouts.front();
  ChartTrace reference = trace_of(bench, finest, kFactor * budget.largest);
  const Eigen::VectorXd truth = reference.exact();
  const std::string reference_name = fmt::format("{}, {} rays", name_of(finest), reference.pupil().size());

  for (const PupilLayout layout : layouts) {
    const std::set<std::int64_t> counts = ray_counts(layout, task, budget);
    const double share = 0.5 * seconds / double(layouts.size() * counts.size());
    for (const std::int64_t rays : counts) {
      bench.say(fmt::format("chart: {} pupil, {} rays", name_of(layout), rays));
      family.rows.push_back(measured_row(bench, layout, rays, truth, reference_name,
                                         std::max(share, 1.1 * budget.per_ray * double(rays))));
    }
  }
  const double doubt = error_of_reference(family.rows, finest, budget.largest);
  for (ChartRow& row : family.rows) row.error_of_reference = doubt;
  family.remark =
      "This is what a surface that is there needs; a fit needs at least 30 rays for each term as well, lest "
      "the "
      "terms follow single rays.";
  return family;
}

}  // namespace aberfit::internal
