#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "aberfit/core/errors.h"
#include "chart_families.h"

namespace aberfit {
namespace {

constexpr std::int64_t kFewestRays = 1024, kMostRays = 1 << 20;
constexpr int kFactor = 4;
// Everything that is held per ray while a statistic is evaluated, and per ray and plane: bounds the reference
// to about 1.5 GB.
constexpr double kBytesPerRay = 200, kBytesPerPlane = 16, kMemory = 1.5e9;

const char* name_of(PupilLayout layout) {
  switch (layout) {
    case PupilLayout::kPolar:
      return "polar";
    case PupilLayout::kRandom:
      return "random";
    case PupilLayout::kSobol:
      return "sobol";
    case PupilLayout::kGrid:
      break;
  }
  return "grid";
}

std::optional<PupilSample> try_pupil(const Aperture& aperture, const PupilOptions& options) {
  try {
    return make_pupil(aperture, options);
  } catch (const ComputationError&) {
    return std::nullopt;  // the layout does not exist for the shape
  }
}

double planes_of(const std::vector<Statistic>& statistics) {
  std::vector<double> planes = {0};
  for (const Statistic& statistic : statistics)
    if (const auto* ee = std::get_if<EncircledEnergyRadius>(&statistic)) planes.push_back(ee->dz);
  std::sort(planes.begin(), planes.end());
  return double(std::unique(planes.begin(), planes.end()) - planes.begin());
}

}  // namespace

ChartFamily chart_pupils(const ChartBench& bench, double seconds) {
  const Task& task = bench.task;
  const ChartClock clock(seconds);
  ChartFamily family{"pupil",
                     "Pupil layouts and ray counts",
                     "largest relative error of the statistics of one surface",
                     "terms, rays and exact statistics",
                     task.equivalence.margin,
                     "margin of equivalence",
                     {},
                     "",
                     ""};
  std::vector<PupilLayout> layouts;
  for (const PupilLayout layout :
       {PupilLayout::kPolar, PupilLayout::kSobol, PupilLayout::kGrid, PupilLayout::kRandom})
    if (try_pupil(task.aperture, {layout, kFewestRays, task.trace.pupil.seed})) layouts.push_back(layout);
  const auto trace_of = [&](PupilLayout layout, std::int64_t rays) {
    return ChartTrace(bench, bench.terms, make_pupil(task.aperture, {layout, rays, task.trace.pupil.seed}),
                      bench.threads);
  };

  // How many rays the budget allows: the reference costs four times the largest count, every layout about
  // three times it (a third more for the smaller counts, and repeats).
  constexpr std::int64_t kProbe = 16384;
  ChartTrace probe = trace_of(layouts.front(), kProbe);
  probe.exact(bench.coefficients, bench.statistics);  // memory and caches
  const double per_ray =
      measure_time(0.02 * seconds, [&] { probe.exact(bench.coefficients, bench.statistics); }).median /
      double(kProbe);
  const double affordable = seconds / (per_ray * (4 + 2.0 * double(layouts.size())));
  const double held =
      kMemory / (kBytesPerRay + kBytesPerPlane * planes_of(bench.statistics)) / double(kFactor);
  std::int64_t largest = kFewestRays * kFactor * kFactor;
  while (largest * kFactor <= kMostRays && double(largest) * kFactor <= std::min(affordable, held))
    largest *= kFactor;

  bench.say("chart: pupils, reference");
  const PupilLayout finest = layouts.front();  // polar where the aperture has it, else Sobol
  ChartTrace reference = trace_of(finest, kFactor * largest);
  const Eigen::VectorXd truth = reference.exact(bench.coefficients, bench.statistics);
  const std::string reference_name = fmt::format("{}, {} rays", name_of(finest), reference.pupil().size());
  const PupilOptions today = task.trace.pupil;

  for (const PupilLayout layout : layouts) {
    std::vector<std::int64_t> counts;
    for (std::int64_t rays = kFewestRays; rays <= largest; rays *= kFactor) counts.push_back(rays);
    const bool own = layout == today.layout && double(today.rays) <= std::max(2.0 * affordable, 1e5);
    if (own && std::find(counts.begin(), counts.end(), today.rays) == counts.end())
      counts.push_back(today.rays);
    std::sort(counts.begin(), counts.end());
    for (const std::int64_t rays : counts) {
      bench.say(fmt::format("chart: {} pupil, {} rays", name_of(layout), rays));
      ChartTrace at = trace_of(layout, rays);
      Eigen::VectorXd values;
      const double share = 0.5 * seconds / double(layouts.size() * counts.size());
      ChartRow row;
      set_time(measure_time(std::max(share, 1.1 * per_ray * double(rays)),
                            [&] { values = at.exact(bench.coefficients, bench.statistics); }),
               &row);
      const StatisticErrors errors = statistic_errors(values, truth, bench.statistics);
      row.family = family.name;
      row.method = name_of(layout);
      row.parameter = "rays";
      row.unit = "1";
      row.value = double(rays);
      row.rays = at.pupil().size();
      row.terms = bench.terms.size();
      row.statistics = std::int64_t(bench.statistics.size());
      row.error = errors.worst;
      row.error_rms = errors.rms;
      row.reference = reference_name;
      row.is_default = layout == today.layout && rays == today.rays;
      family.rows.push_back(std::move(row));
    }
  }
  // Any layout gains at least 1/sqrt(4) from four times the rays, so the reference is off by no more than
  // half of what its own layout was at the largest count.
  double best = std::numeric_limits<double>::infinity();
  for (const ChartRow& row : family.rows)
    if (row.method == name_of(finest) && row.value == double(largest)) best = row.error;
  for (ChartRow& row : family.rows) row.error_of_reference = 0.5 * best;
  family.remark =
      "This is what a surface that is there needs; a fit needs at least 30 rays for each term as well, lest "
      "the "
      "terms follow single rays.";
  mark_rows(&family);
  return family;
}

}  // namespace aberfit
