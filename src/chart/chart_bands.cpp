#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "aberfit/core/errors.h"
#include "aberfit/method/band_choice.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/fit_as_asked.h"
#include "aberfit/method/judged_set.h"
#include "chart_bench.h"

namespace aberfit::internal {
namespace {

// Returns why no cut is charted; empty where cuts are.
std::string why_no_cut(const ChartBench& bench) {
  if (!bench.ground.psd) return "No roughness is given.";
  const std::string obstacle = obstacle_to_split(bench.ground, bench.targets);
  if (!obstacle.empty()) return "The roughness cannot be split: " + obstacle + ".";
  return in_light(bench.targets.fitted).empty() ? "No encircled energies are among the targets." : "";
}

struct Cut {
  Layout layout;
  bool is_default = false;
};

// The bands to chart: the study's own, the automatic one, cuts through the band, and no cut at all.
std::vector<BandSpec> bands_of(const ChartBench& bench) {
  std::vector<BandSpec> bands = {{BandRule::kAuto, 0}, {BandRule::kAll, 0}};
  if (band_rule(bench.task) == BandRule::kCut) bands.push_back(bench.task.terms.band);
  // Below a cycle across, a frequency tilts the mirror; above 1/lambda it does not scatter.
  const double low = std::max(bench.ground.psd->f_min(), 0.5 / bench.ground.radius),
               high = std::min(bench.ground.psd->f_max(), 1 / bench.task.wavelength);
  // Cuts lie in the middles of four equal parts of the band on a logarithmic axis; more would take too long.
  for (double part = 0.125; part < 1 && low < high; part += 0.25)
    bands.push_back({BandRule::kCut, low * std::pow(high / low, part)});
  return bands;
}

// Returns where the terms end [cycles/m]; 0: there are none.
double end_of_terms(const ChartBench& bench, const Layout& layout) {
  if (!layout.ground.split) return bench.ground.psd->f_max();
  return layout.ground.all_scatters() ? 0 : layout.ground.split->cut();
}

// Layouts of the bands in the order of their cuts. Of two nearly equal cuts, the first of bands_of stays.
std::vector<Cut> cuts_of(const ChartBench& bench) {
  const std::vector<BandSpec> bands = bands_of(bench);
  std::vector<Layout> layouts = lay_out(bench.task, requested_physics(bench.task), bands, bench.threads);
  const BandRule own = band_rule(bench.task);
  std::vector<Cut> cuts;
  for (std::size_t k = 0; k < bands.size(); ++k) {
    const double end = end_of_terms(bench, layouts[k]);
    const auto near = std::find_if(cuts.begin(), cuts.end(), [&](const Cut& cut) {
      const double other = end_of_terms(bench, cut.layout);
      // Cuts within 5 % give the same result and do not need a fit each.
      return end <= 1.05 * other && other <= 1.05 * end;
    });
    const bool is_default = own == BandRule::kCut ? k == 2 : bands[k].rule == own;
    if (near != cuts.end()) {
      near->is_default = near->is_default || is_default;
      continue;
    }
    cuts.push_back({std::move(layouts[k]), is_default});
  }
  std::sort(cuts.begin(), cuts.end(), [&](const Cut& a, const Cut& b) {
    return end_of_terms(bench, a.layout) < end_of_terms(bench, b.layout);
  });
  return cuts;
}

std::string setting_of(const ChartBench& bench, const Cut& cut) {
  if (!cut.layout.ground.split) return "terms alone";
  const double end = end_of_terms(bench, cut.layout);
  return end > 0 ? fmt::format("f_c = {:.3g} /m", end) : "scatter alone";
}

// Error of the whole by wave optics, and spread of single mirrors: in tolerances, times the margin.
void judge_row(const ChartBench& bench, const Layout& layout, const Attempt& attempt, ChartRow* row) {
  const JudgedSet judged(layout.targets.fitted, layout.targets.held_out);
  const double margin = bench.task.equivalence.margin;
  std::vector<double> errors;
  double known_to = 0;
  for (std::size_t k = 0; k < attempt.result.judgement.metrics.size(); ++k) {
    const EquivalenceMetric& metric = attempt.result.judgement.metrics[k];
    if (!std::holds_alternative<EncircledEnergyRadius>(judged.targets()[k].statistic)) continue;
    errors.push_back(std::abs(metric.difference) * margin / metric.margin);
    known_to = std::max(known_to, metric.standard_error * margin / metric.margin);
  }
  set_errors(errors, "targets by wave optics", known_to, row);
  const double light = row->error;
  const std::optional<BandShares>& shares = layout.ground.shares;
  const double spread = shares ? shares->spread * margin : 0;
  errors.push_back(spread);
  set_errors(errors, spread > light ? "mean of mirrors with the same terms" : "targets by wave optics",
             known_to, row);
  row->note =
      fmt::format("difference {:.3g} %, spread {:.3g} %{}; TIS of the scatter {:.2g} %", 100 * light,
                  100 * spread, spread > 0 ? fmt::format(" ({})", name_without_unit(shares->spread_of)) : "",
                  shares ? 100 * shares->tis : 0);
}

ChartRow fitted_row(const ChartBench& bench, const Cut& cut) {
  const Layout& layout = cut.layout;
  const double end = end_of_terms(bench, layout);
  const bool both = layout.ground.split && end > 0;
  const std::string setting = setting_of(bench, cut);
  ChartRow row = row_of(both ? "terms and scatter" : setting, "f_c", both ? end : std::nan(""), "/m");
  row.is_default = cut.is_default;
  bench.say("chart: fit by " + setting);
  const RunContext context{bench.threads, bench.say};
  const ChartClock clock(0);
  try {
    const Attempt attempt = fit_as_asked({bench.task, layout.ground, layout.targets, context});
    row.seconds = clock.elapsed();
    row.terms = attempt.result.fitted.terms.size();
    row.rays = attempt.result.fitted.rays;
    judge_row(bench, layout, attempt, &row);
  } catch (const ComputationError& error) {
    row.seconds = clock.elapsed();
    row.note = error.what();
  }
  set_time({row.seconds, row.seconds, row.seconds, 1}, &row);
  row.statistics = std::int64_t(layout.targets.fitted.size() + layout.targets.guides.size());
  return row;
}

// Makes the fits that there is time for, always that of fewest terms and the study's own. left_out: the other
// names.
std::vector<ChartRow> fitted_rows(const ChartBench& bench, const std::vector<Cut>& cuts,
                                  const ChartClock& clock, std::string* left_out) {
  std::vector<ChartRow> rows;
  double last = 0;  // end of the terms of the last fit
  for (const Cut& cut : cuts) {
    // The number of terms grows as the square of their last frequency, and the time of a fit at most with it.
    const double end = end_of_terms(bench, cut.layout), more = last > 0 ? std::pow(end / last, 2) : 1;
    if (!rows.empty() && !cut.is_default && more * rows.back().seconds > clock.left()) {
      *left_out += (left_out->empty() ? "" : ", ") + setting_of(bench, cut);
      continue;
    }
    rows.push_back(fitted_row(bench, cut));
    last = end;
  }
  return rows;
}

}  // namespace

ChartFamily chart_bands(const ChartBench& bench, double seconds) {
  ChartFamily family =
      family_of("bands", "Terms below a frequency f_c, scatter above it",
                "largest wave-optics error of all encircled energies, or spread among mirrors",
                "search for terms, fit and judgement", bench.margin());
  family.skipped = why_no_cut(bench);
  if (!family.skipped.empty()) return family;
  const ChartClock clock(seconds);
  bench.say("chart: cuts of the band");
  std::string left_out;
  family.rows = fitted_rows(bench, cuts_of(bench), clock, &left_out);
  family.remark = fmt::format(
      "The error is the larger of two that the note of a row names. One is the largest difference of the "
      "mean's encircled energies, fitted or held out. The other is the standard deviation of judged "
      "statistics among mirrors with the same terms. The automatic cut keeps it below {:.0f} % of the "
      "margin.",
      100 * law::kShareOfMargin);
  if (!left_out.empty()) family.remark += " Not run for lack of time: " + left_out + ".";
  return family;
}

}  // namespace aberfit::internal
