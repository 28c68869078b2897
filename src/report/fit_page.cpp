// This file makes the page of a fit.
#include "fit_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "aberfit/core/text.h"
#include "aberfit/core/units.h"
#include "aberfit/report/documents.h"
#include "map_report.h"
#include "paragraph.h"
#include "shown_statistic.h"
#include "split_notes.h"
#include "statistic_label.h"
#include "verdict_words.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr std::size_t kWorstFitted = 3, kWorstHeldOut = 5;
constexpr double kCarriesAll = 0.985;  // fraction of the height variance, as of a default order

// Slopes are small angles and shown as angles.
std::string slope(double value) { return format_quantity(value, Dimension::kAngle); }

// The metrics behind the verdict.
const std::vector<EquivalenceMetric>& decided_by(const ResultDocument& result) {
  const auto& light = result.judgement.light;
  return light && light->decides && !light->metrics.empty() ? light->metrics : result.judgement.metrics;
}

// The theory for which the verdict holds.
std::string theory_words(const ResultDocument& result) {
  if (result.judgement.light_decides && !(result.judgement.light && result.judgement.light->no_grid))
    return "wave optics";
  if (result.judgement.light_decides)
    return "rays (no grid can sample the pupil's phase; the model error of rays is included)";
  return result.scene.theory == "ghs" ? "wave optics" : "geometric rays";
}

// Worst metric, such as "ee35 -4 %". in_spreads: also in units of the spread of single mirrors.
std::string worst_words(const std::vector<EquivalenceMetric>& metrics, const ShownStatistics& shown,
                        bool in_spreads = false) {
  const EquivalenceMetric* worst = worst_of(metrics);
  if (!worst) return "-";
  const std::string name = shown.name(worst->name);
  if (!std::isfinite(worst->difference)) return name + " has no value";
  const std::string text = fmt::format("{} {:+.2g} %", name, 100 * worst->difference);
  if (!in_spreads || !(worst->spread > 0)) return text;
  return text + fmt::format(" ({:.2g} standard deviations among mirrors of this specification)",
                            std::abs(worst->difference / worst->spread));
}

// Number of metrics by verdict.
struct Tally {
  explicit Tally(const std::vector<EquivalenceMetric>& metrics) : count(long(metrics.size())) {
    for (const EquivalenceMetric& metric : metrics) {
      different += metric.verdict == Verdict::kDifferent;
      undecided += metric.verdict == Verdict::kUndecided;
      held_out += metric.held_out;
      margin = std::max(margin, metric.margin);
    }
  }
  std::string words() const {
    if (different == 0 && undecided == 0)
      return fmt::format("{} within {:.4g} % of the target",
                         count == 1 ? "the only statistic is" : fmt::format("all {} statistics are", count),
                         100 * margin);
    return fmt::format("{} of {} {} from the target by more than {:.4g} %, {} {} undecided", different,
                       plural(count, "statistic"), different == 1 ? "differs" : "differ", 100 * margin,
                       undecided, undecided == 1 ? "is" : "are");
  }
  // " (90 of them were not fitted)".
  std::string fitted_words() const {
    if (held_out == 0) return " (all were fitted)";
    return fmt::format(" ({} of them {} not fitted)", held_out, held_out == 1 ? "was" : "were");
  }
  long count, different = 0, undecided = 0, held_out = 0;
  double margin = 0;
};

bool by_waves(const ResultDocument& result) { return result.scene.model == "waves"; }

std::string theory_name(const std::string& theory) {
  return theory == "ghs"         ? "generalised Harvey-Shack"
         : theory == "geometric" ? "geometric Harvey-Shack"
         : theory == "given"     ? "given values"
                                 : theory;
}

// One sentence on how to improve the deciding metrics.
std::string what_would_help_here(const ResultDocument& result, const Tally& tally) {
  if (tally.different == 0 && tally.undecided > 0)
    return by_waves(result) ? "The undecided statistics need a larger `equivalence.margin`."
                            : "The undecided statistics need smaller errors: more rays (`trace.rays`) or a "
                              "larger `equivalence.margin`.";
  if (result.map.fit)
    return "The part is measured and cannot be changed; `equivalence.margin` says how far it may be from the "
           "mean of its specification.";
  const auto warned = [&](const char* code) {
    return std::any_of(result.warnings.begin(), result.warnings.end(),
                       [&](const Warning& warning) { return warning.code == code; });
  };
  if (warned("below-diffraction"))
    return "Some given radii are smaller than diffraction allows: give larger ones, a larger aperture or a "
           "shorter wavelength.";
  const EquivalenceMetric* worst = worst_of(decided_by(result));
  if (warned("few-modes") && worst &&
      (worst->name.starts_with("rms_height") || worst->name.starts_with("scatter_")))
    return "Where few modes carry the roughness, the PSF and the height of one surface cannot both be met. "
           "Judge the PSF alone (leave `statistics` out), or give a band of more modes.";
  if (result.fitted.fit.status == FitStatus::kDegenerate)
    return "The fit had no gradient at its start: " + result.fitted.fit.message + ".";
  if (!result.choices.frontier && result.fitted.surface.captured_fraction > 0 &&
      result.fitted.surface.captured_fraction < kCarriesAll)
    return "More terms would help. Leave `terms` out and the program chooses them.";
  // Here the terms carry the roughness. A surface has no more degrees of freedom than modes.
  const double modes = result.has_roughness ? result.scene.numbers.n_eff : 0;
  if (result.choices.frontier && modes > 0 && modes < double(result.fitted.targets.size()))
    return fmt::format(
        "{:.2g} modes carry the roughness (N_eff), but they have to meet {}. A larger margin or a band of "
        "more modes would help; more terms would not.",
        modes, plural(long(result.fitted.targets.size()), "statistic"));
  if (result.interrupted) return "The fit was interrupted; let it run to its end.";
  if (result.fitted.fit.status != FitStatus::kConverged)
    return "The fit ended early (" + to_string(result.fitted.fit.status) +
           "): " + (result.fitted.fit.out_of_iterations ? "more iterations (`fit.max_iterations`), " : "") +
           "another `fit.seed` or " + (result.choices.frontier ? "a larger margin" : "more terms") +
           " would help.";
  if (result.choices.frontier)
    return "None of the tried sets of terms passes. Try another `fit.seed` or a larger margin.";
  return "More terms (leave `terms` out), another `fit.seed` or a larger margin would help.";
}

std::string what_would_help(const ResultDocument& result) {
  const Tally tally(decided_by(result));
  if (!result.judgement.light || !result.judgement.light->decides || result.judgement.light->obstacle.empty())
    return what_would_help_here(result, tally);
  const std::string obstacle = "Wave optics gives no verdict: " + result.judgement.light->obstacle + ".";
  // The metrics that decide instead may still have failed or be undecided.
  return tally.different + tally.undecided > 0 ? obstacle + " " + what_would_help_here(result, tally)
                                               : obstacle;
}

// True for least-squares terms without a specification to judge them.
bool only_map(const ResultDocument& result) { return result.map.fit && !result.has_roughness; }

std::string stopped_by(const ResultDocument& result) {
  return result.stopped_by.empty() ? "" : " (stopped by " + result.stopped_by + ")";
}

// A measured part may differ from the mean of its specification and still be one of its mirrors.
bool part_differs(const ResultDocument& result) {
  return result.map.fit && result.judgement.verdict == Verdict::kDifferent;
}

std::string unjudged(const ResultDocument& result) {
  if (only_map(result))
    return fmt::format(
        "NOT JUDGED: terms were fitted to a measured map by least squares; the residual is {} RMS, and {} on "
        "the points kept back",
        metres_text(result.map.fit->rms_residual), metres_text(result.map.fit->rms_held_out));
  if (result.fitted.fit.status == FitStatus::kNotRun) return "NOT JUDGED: nothing was fitted";
  if (result.map.fit && result.judgement.light)
    return "NOT JUDGED: wave optics gives no verdict: " + result.judgement.light->obstacle;
  return (result.interrupted ? "INTERRUPTED" + stopped_by(result) + ", " : "") +
         ("NOT JUDGED: the fit ended with status " + to_string(result.fitted.fit.status));
}

std::string judged(const ResultDocument& result, const ShownStatistics& shown, const Tally& tally) {
  std::string text =
      (result.interrupted ? "INTERRUPTED" + stopped_by(result) + ", the best so far: " : "") +
      upper_case(to_string(result.judgement.verdict)) +
      (part_differs(result) ? " from the mean, " + worst_words(decided_by(result), shown, true) + ", by "
                            : " by ") +
      theory_words(result) + ": " + tally.words();
  if (result.judgement.confidence > 0)
    text += fmt::format(" at {:.4g} % confidence", 100 * result.judgement.confidence);
  if (!result.map.fit) text += tally.fitted_words();
  if (result.judgement.light && !result.judgement.light->decides && !result.judgement.light->metrics.empty())
    text += "; by wave optics " + upper_case(to_string(result.judgement.light->verdict)) +
            (result.judgement.light->verdict == Verdict::kEquivalent
                 ? ""
                 : " (" + worst_words(result.judgement.light->metrics, shown) + ")");
  return result.judgement.character
             ? text + "; " + character_words(*result.judgement.character, result.judgement.verdict)
             : text;
}

// Instructions to use an equivalent surface.
std::string use_of(const ResultDocument& result) {
  if (!result.band.shares || !(result.band.shares->rest_rms > 0))
    return "Give the surface the terms (coefficients.csv or an export). They describe this mirror "
           "completely; nothing is left to scatter.";
  return result.band.shares->cut > 0 ? std::string(kUse) + " " + kBeware : kUseWithoutTerms;
}

// The same for least-squares terms of a map, which have no target.
void add_map_answers(Page* page, const ResultDocument& result) {
  const MapFitResult& map = *result.map.fit;
  page->answers = {
      {"Why not judged",
       "The study gives a measured map and no roughness, so there is no target. With a `roughness` in the "
       "study the terms are judged against it."},
      {"How certain",
       fmt::format("The residual is {} RMS on the {} fitted points and {} RMS on {} points that the fit did "
                   "not use. Where these two are alike, the terms describe the surface and not its noise.",
                   metres_text(map.rms_residual), map.points, metres_text(map.rms_held_out),
                   map.held_out_points)},
      {"What it rests on",
       fmt::format("Terms are fitted to the measured heights by least squares, without piston and tilt. The "
                   "focus of the terms comes from {}.",
                   by_waves(result) ? "diffraction" : "geometric rays")},
      {"What would change it",
       "More terms leave a smaller residual; another `aperture` or mask changes the points that count."},
      {"What to do next",
       "Give the surface the terms (coefficients.csv or an export). The residual is roughness that they "
       "leave out; `aberfit psd` finds its PSD in the map."}};
}

// Adds the certainty of the answer, its basis and its remedies.
void add_answers(Page* page, const ResultDocument& result, const ShownStatistics& shown) {
  if (only_map(result)) return add_map_answers(page, result);
  const std::vector<EquivalenceMetric>& deciding = decided_by(result);
  const auto say = [&](const char* label, std::string text) {
    page->answers.push_back({label, std::move(text)});
  };
  if (const EquivalenceMetric* worst = worst_of(deciding)) {
    const Tally tally(deciding);
    say("How certain",
        fmt::format("{}{} of {} were not fitted; all were judged on {} that the fit did not use.",
                    result.judgement.confidence > 0
                        ? fmt::format("{:.4g} % confidence. ", 100 * result.judgement.confidence)
                        : "",
                    tally.held_out, plural(tally.count, "statistic"),
                    by_waves(result) ? "a finer grid" : "fresh rays"));
    const double used = std::max(std::abs(worst->interval[0]), std::abs(worst->interval[1]));
    if (std::isfinite(used))
      say("What would change it", fmt::format("The statistic nearest to its limit is {}. With a margin below "
                                              "{:.2g} % the verdict would not be \"equivalent\".",
                                              shown.name(worst->name), 100 * used));
  }
  if (const StatisticSpread* spread = result.scene.spread.worst())
    say("One real mirror",
        "Single mirrors of this specification vary about their mean with a standard deviation of up to " +
            spread_words(*spread) + ".");
  if (result.has_roughness)
    say("What it rests on",
        fmt::format("Targets come from {}, statistics of the surface from {}. The roughness is taken as "
                    "stationary, isotropic and Gaussian with the given PSD, and the theory is scalar.",
                    theory_name(result.scene.theory), by_waves(result) ? "diffraction" : "geometric rays"));
}

void add_headline(Page* page, const ResultDocument& result, const ShownStatistics& shown) {
  if (only_map(result) || result.judgement.metrics.empty()) {
    page->headline = unjudged(result);
    page->tone = only_map(result) ? Page::Tone::kPlain : Page::Tone::kOpen;
    return;
  }
  const Tally tally(decided_by(result));
  page->headline = judged(result, shown, tally);
  page->tone = tone_of(result.judgement.verdict);
  page->advice.push_back(result.judgement.verdict == Verdict::kEquivalent
                             ? use_of(result)
                             : "Worst: " + worst_words(decided_by(result), shown) + ". " +
                                   what_would_help(result));
  // A positive answer with a reservation does not get the colour of one without.
  const bool other_character = result.judgement.character && !result.judgement.character->fault().empty();
  const bool light_differs = result.judgement.light && !result.judgement.light->decides &&
                             !result.judgement.light->metrics.empty() &&
                             result.judgement.light->verdict != Verdict::kEquivalent;
  if (result.judgement.verdict == Verdict::kEquivalent && (other_character || light_differs))
    page->tone = Page::Tone::kOpen;
}

void add_map(Page* page, const ResultDocument& result) {
  const MapFitResult& map = *result.map.fit;
  page->say("Map",
            fmt::format("{} points fitted, {} kept back, RMS height {}; condition number {:.3g}, rank {} of "
                        "{}, {:.0f} independent residuals",
                        map.points, map.held_out_points, metres_text(map.rms_map), map.condition_number,
                        map.rank, result.fitted.terms.size(), map.independent_points) +
                clear_text(result.clear));
  if (const auto& panels = result.map.panels) {
    const MapPanel& measured = panels->measured;
    page->say("", fmt::format("pitch {}; RMS slope {} per axis ({} along x, {} along y)",
                              pitches_text(measured.map.pitch_x, measured.map.pitch_y),
                              slope(std::sqrt(0.5 * (std::pow(measured.rms_slope_x, 2) +
                                                     std::pow(measured.rms_slope_y, 2)))),
                              slope(measured.rms_slope_x), slope(measured.rms_slope_y)));
  }
  if (!only_map(result))
    page->say("", fmt::format("residual {} RMS, {} on the points kept back", metres_text(map.rms_residual),
                              metres_text(map.rms_held_out)));
}

void add_scene(Page* page, const ResultDocument& result) {
  if (result.map.fit) add_map(page, result);
  if (only_map(result)) return;
  if (!result.has_roughness)
    return page->say("Scene", "no roughness is given; every target is a given value");
  const SceneNumbers& scene = result.scene.numbers;
  page->say(result.map.fit ? "Specified" : "Scene",
            fmt::format("RMS height {}, RMS slope {} per axis, correlation length {}, {:.4g} modes carry the "
                        "slope, g {:.3g}, kappa {:.3g}, TIS {:.3g} %, Airy ee90 {}, the paper's R {:.3g}",
                        metres_text(scene.rms_height), slope(scene.rms_slope_per_axis),
                        metres_text(scene.correlation_length), scene.n_eff, scene.g, scene.kappa,
                        100 * scene.tis, metres_text(scene.airy_ee90), scene.paper_ratio_r));
  page->say("Model", fmt::format("targets {}, surface {}, needed {}: {}", result.scene.theory,
                                 result.scene.model, result.scene.needed.empty() ? "-" : result.scene.needed,
                                 result.scene.reason.empty() ? scene.reason : result.scene.reason));
  if (const auto& errors = result.scene.errors)
    page->say("", fmt::format("generalised Harvey-Shack gives ee50 {}, ee80 {}, ee90 {}; rays are wrong by "
                              "{} % (ee50) and {} % (ee90)",
                              metres_text(errors->ghs.ee50), metres_text(errors->ghs.ee80),
                              metres_text(errors->ghs.ee90), signed_percent(errors->ray_ee50),
                              signed_percent(errors->ray_ee90)));
  if (const StatisticSpread* worst = result.scene.spread.worst())
    page->say("", "single mirrors of this specification vary by up to " + spread_words(*worst) +
                      ", one standard deviation");
}

void add_solver(Page* page, const ResultDocument& result) {
  const std::string points = plural(long(result.fitted.rays), by_waves(result) ? "grid point" : "ray");
  const FitResult& fit = result.fitted.fit;
  const std::string terms = plural(long(result.fitted.terms.size()), "term");
  if (result.map.fit)
    return page->say("Fit", only_map(result) ? fmt::format("{}, {:.3g} s; PSF by {}", to_string(fit.status),
                                                           fit.seconds, points)
                                             : fmt::format("{}, {:.3g} s; {}, least squares",
                                                           to_string(fit.status), fit.seconds, terms));
  if (fit.status == FitStatus::kNotRun) return;
  page->say("Fit", fmt::format("{} after {}, {}, {:.3g} s: {}", to_string(fit.status),
                               plural(fit.iterations, "iteration"), plural(fit.evaluations, "evaluation"),
                               fit.seconds, fit.message));
  page->say("", fmt::format("{}, {}, {}; the targets determine {} of {} directions and do not depend on {}",
                            terms, points, plural(long(result.fitted.targets.size()), "target"), fit.rank,
                            result.fitted.terms.size(), fit.null_directions));
}

void add_surface(Page* page, const ResultDocument& result) {
  const EquivalentSurface& surface = result.fitted.surface;
  if (!(surface.rms_height > 0)) return;
  std::string text =
      fmt::format("RMS height {}, RMS slope {} per axis, g {:.3g}", metres_text(surface.rms_height),
                  slope(surface.rms_slope_per_axis), surface.g);
  if (std::isfinite(surface.kappa)) text += fmt::format(", kappa {:.3g}", surface.kappa);
  if (surface.captured_fraction > 0)
    text += fmt::format("; the terms can carry {:.4g} % of the specified height variance",
                        100 * surface.captured_fraction);
  page->say("Surface", text);
}

void add_fit(Page* page, const ResultDocument& result) {
  add_solver(page, result);
  const bool cells = by_waves(result);
  if (result.choices.rays && (result.choices.rays->automatic || cells) &&
      !result.choices.rays->reason.empty())
    page->say(cells ? "Grid" : "Rays", result.choices.rays->reason);
  if (result.band.shares) add_band(page, *result.band.shares, result.band.scatter, result.fitted.surface);
  if (result.choices.frontier) add_frontier(page, *result.choices.frontier, cells ? "points" : "rays");
  add_surface(page, result);
}

// One line of the statistics table.
struct Line {
  std::string name;
  double target = NAN, fitted = NAN, fresh = NAN;
  const EquivalenceMetric* metric = nullptr;
  bool at_focus = false, held_out = false;

  // Rank of this line: verdict first, then the used fraction of the margin.
  std::pair<int, double> severity() const {
    if (!metric) return {0, 0.0};
    const int rank = metric->verdict == Verdict::kDifferent   ? 2
                     : metric->verdict == Verdict::kUndecided ? 1
                                                              : 0;
    const double used = std::abs(metric->difference) / metric->margin;
    return {rank, std::isfinite(used) ? used : HUGE_VAL};
  }
};

std::vector<Line> statistic_lines(const ResultDocument& result) {
  std::map<std::string, const EquivalenceMetric*> judged;
  for (const EquivalenceMetric& metric : result.judgement.metrics) judged.emplace(metric.name, &metric);
  const std::vector<std::string> names = unique_names(result.fitted.targets);
  std::vector<Line> lines;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto at = [&](const Eigen::VectorXd& v) {
      return Eigen::Index(k) < v.size() ? v[Eigen::Index(k)] : NAN;
    };
    Line line{names[k],
              result.fitted.targets[k].value,
              at(result.fitted.values),
              at(result.fitted.validated),
              nullptr,
              true,
              false};
    line.at_focus = is_at_focus(line.name);
    if (const auto it = judged.find(line.name); it != judged.end()) {
      line.metric = it->second;
      if (std::isnan(line.fresh)) line.fresh = it->second->model;
      judged.erase(it);
    }
    lines.push_back(line);
  }
  for (const EquivalenceMetric& metric : result.judgement.metrics)
    if (judged.contains(metric.name))
      lines.push_back({metric.name, metric.target, NAN, metric.model, &metric, false, metric.held_out});
  return lines;
}

// Lines of the table with a common title.
struct Section {
  std::string title;
  std::vector<Line> lines;
};

Section section_of(const std::string& title, const std::vector<Line>& lines, auto wanted) {
  Section section{title, {}};
  std::copy_if(lines.begin(), lines.end(), std::back_inserter(section.lines), wanted);
  return section;
}

// The `count` most severe of those lines, worst first. The title gives the number of all.
Section worst_section(const std::string& title, std::size_t count, const std::vector<Line>& lines,
                      auto wanted) {
  Section section = section_of(title, lines, wanted);
  std::stable_sort(section.lines.begin(), section.lines.end(),
                   [](const Line& a, const Line& b) { return a.severity() > b.severity(); });
  const std::size_t of = section.lines.size();
  section.lines.resize(std::min(count, of));
  section.title += fmt::format(": the worst {} of {}", section.lines.size(), of);
  return section;
}

std::vector<Section> sections_of(const ResultDocument& result, const std::vector<Line>& lines, bool all) {
  const auto fitted = [](const Line& line) { return !line.held_out; };
  const auto held_out = [](const Line& line) { return line.held_out; };
  const std::string of_map = "Statistics of the terms at the focus, by " + result.scene.model;
  if (all)
    return {section_of(only_map(result) ? of_map : "Fitted statistics", lines, fitted),
            section_of("Held-out statistics (judged, not fitted)", lines, held_out)};
  return {section_of(only_map(result) ? of_map
                     : result.map.fit ? "Statistics of the part at the focus"
                                      : "Fitted statistics at the focus",
                     lines, [](const Line& l) { return l.at_focus; }),
          worst_section("Fitted in other planes", kWorstFitted, lines,
                        [](const Line& l) { return !l.held_out && !l.at_focus; }),
          worst_section("Held out (judged, not fitted)", kWorstHeldOut, lines, held_out)};
}

// with_spreads: adds the difference in units of the spread of single mirrors.
void add_row(Page::Table* table, const Line& line, const ShownStatistics& shown, bool with_spreads) {
  std::string difference = "-", interval = "-", verdict = "-";
  Page::Tone tone = Page::Tone::kPlain;
  if (const EquivalenceMetric* metric = line.metric) {
    difference = signed_percent(metric->difference);
    if (std::isfinite(metric->interval[0]) && std::isfinite(metric->interval[1]))
      interval = signed_percent(metric->interval[0]) + " .. " + signed_percent(metric->interval[1]);
    verdict = verdict_word(metric->verdict);
    if (metric->verdict != Verdict::kEquivalent) tone = tone_of(metric->verdict);
  } else if (std::isfinite(line.target) && line.target != 0 && std::isfinite(line.fresh)) {
    difference = signed_percent(line.fresh / line.target - 1);
  }
  std::vector<std::string> cells = {shown.name(line.name), shown.value(line.name, line.target),
                                    shown.value(line.name, line.fitted), shown.value(line.name, line.fresh),
                                    difference};
  if (with_spreads)
    cells.push_back(line.metric && line.metric->spread > 0
                        ? fmt::format("{:+.2f}", line.metric->difference / line.metric->spread)
                        : "-");
  cells.push_back(interval);
  cells.push_back(verdict);
  table->add(std::move(cells), tone);
}

void add_statistics(Page* page, const ResultDocument& result, const ShownStatistics& shown, bool all) {
  const std::vector<Line> lines = statistic_lines(result);
  if (lines.empty()) return;
  const bool with_spreads = result.map.fit && !only_map(result);
  const double confidence = result.judgement.confidence;
  Page::Table table{
      "", {"", "target", "fitted", by_waves(result) ? "fresh grid" : "fresh rays", "diff. [%]"}, "lrrrr"};
  if (with_spreads) table.heads.push_back("spreads"), table.align += 'r';
  table.heads.push_back(confidence > 0 ? fmt::format("{:.3g} % interval [%]", 100 * (2 * confidence - 1))
                                       : "interval [%]");
  table.heads.push_back("verdict");
  table.align += "rl";
  for (const Section& section : sections_of(result, lines, all)) {
    if (section.lines.empty()) continue;
    table.add({section.title});
    for (const Line& line : section.lines) add_row(&table, line, shown, with_spreads);
  }
  page->parts.push_back(std::move(table));
}

// Adds the verdict of wave optics if the fit's own metrics are not by wave optics.
void add_light(Page* page, const ResultDocument& result, const ShownStatistics& shown, bool all) {
  const auto& light = result.judgement.light;
  if (!light) return;
  if (light->metrics.empty()) {
    if (!light->obstacle.empty()) page->say("Light", "no verdict: " + light->obstacle);
    return;
  }
  Page::Table table{
      std::string("The same surface by wave optics") + (light->decides ? " (this decides)" : ""),
      {"", light->theory, "surface", "diff. [%]", "verdict"},
      "lrrrl"};
  const EquivalenceMetric* worst = worst_of(light->metrics);
  for (const EquivalenceMetric& metric : light->metrics) {
    if (!all && &metric != worst && (!is_at_focus(metric.name) || metric.held_out)) continue;
    table.add({shown.name(metric.name), shown.value(metric.name, metric.target),
               shown.value(metric.name, metric.model), signed_percent(metric.difference),
               verdict_word(metric.verdict) + (&metric == worst ? ", the worst of all" : "")},
              metric.verdict == Verdict::kEquivalent ? Page::Tone::kPlain : tone_of(metric.verdict));
  }
  page->parts.push_back(std::move(table));
}

// Explains the differences, and says if the margin is fine enough to see the roughness.
void add_footnotes(Page* page, const ResultDocument& result) {
  const auto any = [&](auto wanted) {
    return std::any_of(result.judgement.metrics.begin(), result.judgement.metrics.end(), wanted);
  };
  if (any([](const EquivalenceMetric& m) { return std::isfinite(m.tolerance_share); }))
    page->say(
        "diff.",
        fmt::format(
            "for an encircled-energy radius: nominal fraction minus the energy fraction inside the target's "
            "radius, over max(r dE/dr, {0}); for ee_within and ensquared_within: fraction minus target, over "
            "{0}{1}",
            kFlattestCurve,
            any([](const EquivalenceMetric& m) { return m.name == "strehl" || m.name.starts_with("mtf@"); })
                ? fmt::format("; for strehl and mtf: value minus target, over the larger of target and {}",
                              kFlattestCurve)
                : ""));
  if (result.map.fit && result.scene.spread.worst())
    page->say("spreads", "diff. in standard deviations among mirrors of this specification");
  if (result.judgement.perfect)
    page->say(
        "Perfect",
        fmt::format(
            "the perfect mirror's worst statistic by wave optics{} is {:.3g} tolerances from its target ({})",
            result.judgement.perfect->mismatch < 1 ? "" : " in the focus", result.judgement.perfect->mismatch,
            name_without_unit(result.judgement.perfect->statistic)));
}

void add_spectrum(Page* page, const ResultDocument& result) {
  if (result.fitted.spectrum.empty()) return;
  Page::Table table{"PSD bins of the term surface",
                    {"band [cycles/m]", "target [m^4]", "fitted [m^4]", "diff. [%]"},
                    "lrrr"};
  for (const SpectrumBin& bin : result.fitted.spectrum)
    table.add({fmt::format("{:.4g} .. {:.4g}", bin.low, bin.high), fmt::format("{:.4g}", bin.target),
               fmt::format("{:.4g}", bin.fitted), signed_percent(bin.fitted / bin.target - 1)});
  page->parts.push_back(std::move(table));
}

}  // namespace

Page page_of(const ResultDocument& result, bool all) {
  const ShownStatistics shown(result.fitted.targets);
  Page page;
  add_headline(&page, result, shown);
  add_answers(&page, result, shown);
  page.title = result.title;
  add_scene(&page, result);
  add_fit(&page, result);
  add_statistics(&page, result, shown, all);
  add_map_light(&page, result);
  add_light(&page, result, shown, all);
  add_footnotes(&page, result);
  add_spectrum(&page, result);
  if (result.judgement.character) add_character(&page, *result.judgement.character);
  page.warnings = result.warnings;
  return page;
}

}  // namespace aberfit
