#include "aberfit/chart/check.h"

#include "aberfit/core/errors.h"
#include "aberfit/method/band_choice.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/method/ray_count.h"
#include "chart_bench.h"

namespace aberfit {
namespace {

// Of a search the terms are not known: their frequencies ask for finer grids than light does only where they
// are many.
std::optional<CheckedCells> checked_cells(const Task& task, const Groundwork& ground, TermSet terms,
                                          const TargetSets& targets) {
  if (ground.use.model != FocusModel::kWaves) return std::nullopt;
  if (task.terms.automatic()) terms.zernike.clear(), terms.fourier.clear();
  const std::vector<Target> all = all_targets(targets);
  try {
    const double across = 2 * ground.radius;
    return CheckedCells{across / wave_pitch(task, terms, all, ground.split.get(), kFirstCoarsening),
                        across / judging_pitch(task, terms, all, ground.split.get())};
  } catch (const ComputationError&) {
    return std::nullopt;
  }
}

// What the fit would take if all of the roughness were terms.
CheckedWholeBand whole_band(const Task& task, Groundwork ground, const TargetSets& targets,
                            const FitRates& rates, int threads) {
  ground.split.reset();
  ground.prior_psd = ground.term_psd = ground.psd;
  CheckedWholeBand whole;
  double captured = 0;
  const TermSet terms = make_terms(task, ground, task.terms, &captured);
  try {
    whole.seconds = predict_fit(task, ground, terms, targets, rates, threads).seconds;
  } catch (const ComputationError&) {  // no grid
  }
  return whole;
}

constexpr double kLong = 60;  // s

// The key that shortens a long fit.
std::string remedy_of(const Task& task, const Groundwork& ground, const TargetSets& targets,
                      const CheckReport& report) {
  if (!report.prediction || report.prediction->seconds <= kLong) return "";
  const bool waves = ground.use.model == FocusModel::kWaves;
  // What is automatic and found nothing to cut finds nothing when asked by name.
  if (ground.psd && !ground.split && band_rule(task) != BandRule::kAuto &&
      obstacle_to_split(ground, targets).empty())
    return "`\"terms\": {\"band\": \"auto\"}`: frequencies that need no term, if there are any, become "
           "scatter";
  if (!task.terms.automatic()) return "`terms`: fewer of them, or leave it out and they are chosen";
  if (!waves && task.trace.pupil.rays) return "`trace.rays`: fewer, or leave it out";
  return "`equivalence.margin`: a larger one needs fewer terms and cells, and lets more of the band be "
         "scatter";
}

void predict(const Task& task, const Groundwork& ground, const TermSet& terms, const TargetSets& targets,
             const FitRates& rates, CheckReport* report) {
  report->rates = rates.source;
  try {
    report->prediction = predict_fit(task, ground, terms, targets, rates, report->threads);
  } catch (const ComputationError& error) {  // a grid finer than there is: `fit` will say so, too
    report->unpredicted = error.what();
  }
}

}  // namespace

CheckReport make_check(const Task& task, const FitRates& rates, int threads) {
  const internal::ChartClock clock(0);
  const auto [ground, targets] = lay_out(task, threads);
  const double laying_out = clock.elapsed();
  double captured = 0;
  const TermSet terms = make_terms(task, ground, task.terms, &captured);
  CheckReport report;
  report.warnings = scene_warnings(task, ground, terms, captured);
  if (task.terms.automatic())  // not yet chosen
    std::erase_if(report.warnings, [](const Warning& warning) { return warning.code == "truncated-terms"; });
  report.warnings.insert(report.warnings.end(), targets.warnings.begin(), targets.warnings.end());
  report.mirror = characterise(task.mirror, task.aperture);
  report.focal_sigma = ground.focal_sigma;
  report.theory = targets.theory;
  report.model = ground.use.model;
  report.reason = ground.use.reason;
  if (ground.psd) {
    report.scene = scene_facts(ground, targets.theory);
    report.scene->mean_light = specified_light(ground);
    report.scene->spread = mirror_spread(task, ground, targets, threads);
    report.too_simple =
        ground.use.choice->model != FocusModel::kRays && !ground.use.in_light(targets_are_given(task));
    report.light_decides = ground.use.light_decides;
  }
  report.terms = {terms.size(), captured, {}};
  if (task.terms.automatic() && ground.psd && !ground.all_scatters())
    report.terms.expected = expected_orders(ground);
  report.statistics = {targets.fitted.size(), targets.guides.size(), targets.held_out.size()};
  report.theory_error = ground.use.theory_error;
  report.cells = checked_cells(task, ground, terms, targets);
  report.fitted = targets.fitted;
  report.held_out = targets.held_out;
  report.automatic_rays = !task.trace.pupil.rays;
  report.rays = task.trace.pupil.rays.value_or(first_rays(terms.size()));
  report.starts = task.fit.starts.value_or(1);
  report.threads = threads;
  report.shares = ground.shares;
  predict(task, ground, terms, targets, rates, &report);
  if (report.prediction && ground.mean_spot) {
    // Done just now: measured.
    auto& [stage, seconds] = report.prediction->stages.front();
    report.prediction->seconds += laying_out - seconds;
    stage = ground.split ? "targets and cut" : "targets";
    seconds = laying_out;
  }
  if (ground.split) report.whole = whole_band(task, ground, targets, rates, threads);
  report.remedy = remedy_of(task, ground, targets, report);
  return report;
}

MapCheckReport make_map_check(const HeightMap& map, const TermSet& terms, int threads) {
  MapCheckReport report;
  report.columns = map.columns();
  report.rows = map.rows();
  report.valid = valid_count(map);
  report.pitch_x = map.pitch_x;
  report.pitch_y = map.pitch_y;
  report.terms = terms.size();
  report.seconds = predict_map_fit(double(report.valid), double(report.terms), threads);
  report.threads = threads;
  return report;
}

}  // namespace aberfit
