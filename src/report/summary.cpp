#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "aberfit/core/text.h"
#include "aberfit/core/units.h"
#include "aberfit/report/band_shares.h"
#include "aberfit/report/character.h"
#include "aberfit/report/frontier.h"
#include "aberfit/report/result.h"
#include "map_report.h"
#include "paragraph.h"
#include "statistic_label.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr std::size_t kWorstFitted = 3, kWorstHeldOut = 5;
constexpr double kCarriesAll = 0.985;  // of the height variance, as a default order does

std::string quantity(double value, const std::string& name) {
  return four_digits(value, dimension_of_name(name));
}

// Slopes are small angles and read best as such.
std::string slope(double value) { return format_quantity(value, Dimension::kAngle); }

std::string percent(double fraction) {
  const double value = 100.0 * fraction;
  if (!std::isfinite(value)) return "-";
  return std::abs(value) < 99.9995 ? fmt::format("{:+.3f}", value) : fmt::format("{:+.4g}", value);
}

// What the verdict was made on.
const std::vector<EquivalenceMetric>& decided_by(const ResultDocument& result) {
  const auto& light = result.light;
  return light && light->decides && !light->metrics.empty() ? light->metrics : result.metrics;
}

// The theory that a verdict is true of.
std::string theory_words(const ResultDocument& result) {
  if (result.light_decides && !(result.light && result.light->no_grid)) return "light";
  if (result.light_decides) return "rays (no grid holds the pupil's phase; their model error is allowed for)";
  return result.theory == "ghs" ? "light" : "geometric rays";
}

const EquivalenceMetric* worst_of(const std::vector<EquivalenceMetric>& metrics) {
  const auto used = [](const EquivalenceMetric& m) {
    const double most = std::max(std::abs(m.interval[0]), std::abs(m.interval[1])) / m.margin;
    return std::isfinite(most) ? most : HUGE_VAL;
  };
  const EquivalenceMetric* worst = nullptr;
  for (const EquivalenceMetric& metric : metrics)
    if (!worst || used(metric) > used(*worst)) worst = &metric;
  return worst;
}

std::string verdict_word(Verdict verdict) {
  return verdict == Verdict::kDifferent ? "DIFFERENT" : to_string(verdict);
}

// Of a name of a statistic.
bool is_at_focus(const std::string& name) {
  const std::size_t plane = name.find('@');
  return plane == std::string::npos || name.compare(plane, 6, "@ring=") == 0 || name.starts_with("mtf@");
}

// "ee35 -4 %"; in_spreads: also over what single mirrors differ by.
std::string worst_words(const std::vector<EquivalenceMetric>& metrics, bool in_spreads = false) {
  const EquivalenceMetric* worst = worst_of(metrics);
  if (!worst) return "-";
  if (!std::isfinite(worst->difference)) return name_without_unit(worst->name) + " has no value";
  const std::string text =
      fmt::format("{} {:+.2g} %", name_without_unit(worst->name), 100 * worst->difference);
  if (!in_spreads || !(worst->spread > 0)) return text;
  return text + fmt::format(" ({:.2g} of the spread of mirrors of this specification)",
                            std::abs(worst->difference / worst->spread));
}

// How many of the metrics are what.
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
      return fmt::format("all {} within +-{:.4g} %", plural(count, "statistic"), 100 * margin);
    return fmt::format("{} of {} different, {} undecided, margin +-{:.4g} %", different,
                       plural(count, "statistic"), undecided, 100 * margin);
  }
  long count, different = 0, undecided = 0, held_out = 0;
  double margin = 0;
};

// One sentence for whoever has to do better by what decides.
std::string what_would_help_here(const ResultDocument& result, const Tally& tally) {
  if (tally.different == 0 && tally.undecided > 0)
    return "What is undecided needs smaller errors: more rays (`trace.rays`) or a larger margin.";
  if (result.map)
    return "The part is what it is: `equivalence.margin` says how far it may be from the mean of its "
           "specification.";
  const auto warned = [&](const char* code) {
    return std::any_of(result.warnings.begin(), result.warnings.end(),
                       [&](const Warning& warning) { return warning.code == code; });
  };
  if (warned("below-diffraction"))
    return "Some given radii are smaller than diffraction allows: larger ones, a larger aperture or a "
           "shorter "
           "wavelength.";
  const EquivalenceMetric* worst = worst_of(decided_by(result));
  if (warned("few-modes") && worst &&
      (worst->name.starts_with("rms_height") || worst->name.starts_with("scatter_")))
    return "Light and the height of the surface contradict each other where few modes carry the roughness: "
           "judge light alone (leave `statistics` out), or give a band of more modes.";
  if (result.fit.status == FitStatus::kDegenerate)
    return "The fit had no gradient to start along: " + result.fit.message + ".";
  if (!result.frontier && result.surface.captured_fraction > 0 &&
      result.surface.captured_fraction < kCarriesAll)
    return "More terms would help: leave `terms` out and they are chosen.";
  // The terms carry the roughness; no surface has more to give than its modes.
  const double modes = result.has_roughness ? result.scene.n_eff : 0;
  if (result.frontier && modes > 0 && modes < double(result.targets.size()))
    return fmt::format(
        "{:.2g} modes carry the roughness (N_eff), fewer than the {} they have to meet: a larger margin or a "
        "band of more modes would help, more terms would not.",
        modes, plural(long(result.targets.size()), "statistic"));
  if (result.interrupted) return "The fit was interrupted: let it come to its end.";
  if (result.fit.status != FitStatus::kConverged)
    return "The fit ended early (" + to_string(result.fit.status) +
           "): " + (result.fit.out_of_iterations ? "more iterations (`fit.max_iterations`), " : "") +
           "another `fit.seed` or " + (result.frontier ? "a larger margin" : "more terms") + " would help.";
  if (result.frontier) return "No set of terms that was tried passes: another `fit.seed` or a larger margin.";
  return "More terms (leave `terms` out), another `fit.seed` or a larger margin would help.";
}

std::string what_would_help(const ResultDocument& result) {
  const Tally tally(decided_by(result));
  if (!result.light || !result.light->decides || result.light->obstacle.empty())
    return what_would_help_here(result, tally);
  const std::string obstacle = "Light has no answer: " + result.light->obstacle + ".";
  // What decides in its place may have left something open, or nothing.
  return tally.different + tally.undecided > 0 ? obstacle + " " + what_would_help_here(result, tally)
                                               : obstacle;
}

// Least-squares terms that nothing says what to make of.
bool only_map(const ResultDocument& result) { return result.map && !result.has_roughness; }

std::string stopped_by(const ResultDocument& result) {
  return result.stopped_by.empty() ? "" : " (stopped by " + result.stopped_by + ")";
}

// A measured part that is not the mean of its specification may well be one of its mirrors.
bool part_differs(const ResultDocument& result) {
  return result.map && result.verdict == Verdict::kDifferent;
}

std::string headline(const ResultDocument& result) {
  if (only_map(result))
    return paragraph(
        "",
        fmt::format(
            "NOT JUDGED - least-squares terms of a measured map: residual {} RMS, {} on the points kept back",
            metres_text(result.map->rms_residual), metres_text(result.map->rms_held_out)),
        0);
  if (result.metrics.empty()) {
    if (result.fit.status == FitStatus::kNotRun) return paragraph("", "NOT JUDGED - nothing was fitted", 0);
    if (result.map && result.light)
      return paragraph("", "NOT JUDGED - light has no answer: " + result.light->obstacle, 0);
    return paragraph("",
                     (result.interrupted ? "INTERRUPTED" + stopped_by(result) + ", " : "") +
                         ("NOT JUDGED - fit: " + to_string(result.fit.status)),
                     0);
  }
  const std::vector<EquivalenceMetric>& deciding = decided_by(result);
  const Tally tally(deciding);
  std::string text =
      (result.interrupted ? "INTERRUPTED" + stopped_by(result) + ", the best so far: " : "") +
      upper_case(to_string(result.verdict)) +
      (part_differs(result) ? " from the mean, " + worst_words(deciding, true) + ", in " : " in ") +
      theory_words(result);
  if (result.light && !result.light->decides && !result.light->metrics.empty())
    text += "; in light " + upper_case(to_string(result.light->verdict)) +
            (result.light->verdict == Verdict::kEquivalent ? ""
                                                           : " (" + worst_words(result.light->metrics) + ")");
  if (result.character) text += "; " + character_words(*result.character, result.verdict);
  text += " - " + tally.words();
  if (const double confidence = result.confidence; confidence > 0)
    text += fmt::format(", {:.4g} % confidence", 100 * confidence);
  text = paragraph("", text + fmt::format("; {} held out", tally.held_out), 0);
  if (result.verdict != Verdict::kEquivalent)
    text += paragraph("", "Worst: " + worst_words(deciding) + ". " + what_would_help(result), 0);
  return text;
}

std::string map_lines(const ResultDocument& result) {
  const MapFitResult& map = *result.map;
  std::string text = paragraph(
      "Map", fmt::format("{} points fitted, {} kept back, RMS height {}; condition number {:.3g}, "
                         "rank {} of {}, residuals worth {:.0f} independent points",
                         map.points, map.held_out_points, metres_text(map.rms_map), map.condition_number,
                         map.rank, result.terms.size(), map.independent_points) +
                 clear_text(result.clear));
  if (const auto& panels = result.map_panels) {
    const MapPanel& measured = panels->measured;
    text += paragraph("", fmt::format("pitch {}; RMS slope {} per axis ({} along x, {} along y)",
                                      pitches_text(measured.map.pitch_x, measured.map.pitch_y),
                                      slope(std::sqrt(0.5 * (std::pow(measured.rms_slope_x, 2) +
                                                             std::pow(measured.rms_slope_y, 2)))),
                                      slope(measured.rms_slope_x), slope(measured.rms_slope_y)));
  }
  if (!only_map(result))
    text += paragraph("", fmt::format("residual {} RMS, {} on the points kept back",
                                      metres_text(map.rms_residual), metres_text(map.rms_held_out)));
  return text;
}

std::string scene_lines(const ResultDocument& result) {
  if (only_map(result)) return map_lines(result);
  if (!result.has_roughness) return paragraph("Scene", "no roughness given; all targets are values");
  const SceneNumbers& scene = result.scene;
  std::string text = result.map ? map_lines(result) : "";
  text += paragraph(
      result.map ? "Specified" : "Scene",
      fmt::format("RMS height {}, RMS slope {} per axis, correlation length {}, {:.4g} modes carry the "
                  "slope, g {:.3g}, kappa {:.3g}, TIS {:.3g} %, Airy ee90 {}, the paper's R {:.3g}",
                  metres_text(scene.rms_height), slope(scene.rms_slope_per_axis),
                  metres_text(scene.correlation_length), scene.n_eff, scene.g, scene.kappa, 100 * scene.tis,
                  metres_text(scene.airy_ee90), scene.paper_ratio_r));
  text += paragraph("Model", fmt::format("targets {}, surface {}, needed {}: {}", result.theory, result.model,
                                         result.needed.empty() ? "-" : result.needed,
                                         result.model_reason.empty() ? scene.reason : result.model_reason));
  if (const auto& errors = result.errors)
    text += paragraph(
        "", fmt::format("generalised Harvey-Shack ee50 {}, ee80 {}, ee90 {}; rays are off by {} % (ee50) and "
                        "{} % (ee90)",
                        metres_text(errors->ghs.ee50), metres_text(errors->ghs.ee80),
                        metres_text(errors->ghs.ee90), percent(errors->ray_ee50), percent(errors->ray_ee90)));
  if (const StatisticSpread* worst = result.spread.worst())
    text += paragraph("", "single mirrors of this specification differ by " + spread_words(*worst) +
                              ", one standard deviation, at most");
  return text;
}

// Waves know no rays: a grid of cells over the pupil, judged on another one.
bool by_waves(const ResultDocument& result) { return result.model == "waves"; }

std::string fit_lines(const ResultDocument& result) {
  const std::string points = plural(long(result.rays), by_waves(result) ? "grid cell" : "ray");
  const FitResult& fit = result.fit;
  std::string out;
  if (result.map) {
    out += paragraph(
        "Fit", only_map(result)
                   ? fmt::format("{}, {:.3g} s; light by {}", to_string(fit.status), fit.seconds, points)
                   : fmt::format("{}, {:.3g} s; {}, least squares", to_string(fit.status), fit.seconds,
                                 plural(long(result.terms.size()), "term")));
  } else if (fit.status != FitStatus::kNotRun) {
    out += paragraph("Fit", fmt::format("{} after {}, {}, {:.3g} s: {}", to_string(fit.status),
                                        plural(fit.iterations, "iteration"),
                                        plural(fit.evaluations, "evaluation"), fit.seconds, fit.message));
    out +=
        paragraph("", fmt::format("{}, {}, {}; {} of {} directions are set by the targets, {} unseen by them",
                                  plural(long(result.terms.size()), "term"), points,
                                  plural(long(result.targets.size()), "target"), fit.rank,
                                  result.terms.size(), fit.null_directions));
  }
  const bool cells = by_waves(result);
  if (result.ray_choice && (result.ray_choice->automatic || cells) && !result.ray_choice->reason.empty())
    out += paragraph(cells ? "Cells" : "Rays", result.ray_choice->reason);
  if (result.shares) out += band_lines(*result.shares, result.scatter, result.surface);
  if (result.frontier) out += frontier_lines(*result.frontier, by_waves(result) ? "cells" : "rays");
  const EquivalentSurface& surface = result.surface;
  if (surface.rms_height > 0) {
    std::string text =
        fmt::format("RMS height {}, RMS slope {} per axis, g {:.3g}", metres_text(surface.rms_height),
                    slope(surface.rms_slope_per_axis), surface.g);
    if (std::isfinite(surface.kappa)) text += fmt::format(", kappa {:.3g}", surface.kappa);
    if (surface.captured_fraction > 0)
      text += fmt::format("; the terms can carry {:.4g} % of the specified height variance",
                          100 * surface.captured_fraction);
    out += paragraph("Surface", text);
  }
  return out;
}

// One line of the statistics table.
struct Line {
  std::string name;
  double target = NAN, fitted = NAN, fresh = NAN;
  const EquivalenceMetric* metric = nullptr;
  bool at_focus = false, held_out = false;

  // How much this line deserves to be seen: verdict first, then the share of the margin that is used up.
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
  for (const EquivalenceMetric& metric : result.metrics) judged.emplace(metric.name, &metric);
  const std::vector<std::string> names = unique_names(result.targets);
  std::vector<Line> lines;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto at = [&](const Eigen::VectorXd& v) {
      return Eigen::Index(k) < v.size() ? v[Eigen::Index(k)] : NAN;
    };
    Line line{names[k], result.targets[k].value, at(result.fitted), at(result.validated), nullptr, true,
              false};
    line.at_focus = is_at_focus(line.name);
    if (const auto it = judged.find(line.name); it != judged.end()) {
      line.metric = it->second;
      if (std::isnan(line.fresh)) line.fresh = it->second->model;
      judged.erase(it);
    }
    lines.push_back(line);
  }
  for (const EquivalenceMetric& metric : result.metrics)
    if (judged.contains(metric.name))
      lines.push_back({metric.name, metric.target, NAN, metric.model, &metric, false, metric.held_out});
  return lines;
}

// Lines of the table under a title.
struct Section {
  std::string title;
  std::vector<Line> lines;
};

Section section_of(const std::string& title, const std::vector<Line>& lines, auto wanted) {
  Section section{title, {}};
  std::copy_if(lines.begin(), lines.end(), std::back_inserter(section.lines), wanted);
  return section;
}

// The `count` most severe of those lines, worst first; the title says of how many.
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

// with_spreads: how many spreads of single mirrors the difference is.
std::string table_row(const Line& line, std::size_t name_width, bool with_spreads) {
  std::string difference = "-", interval = "-", verdict = "-";
  if (const EquivalenceMetric* metric = line.metric) {
    difference = percent(metric->difference);
    if (std::isfinite(metric->interval[0]) && std::isfinite(metric->interval[1]))
      interval = percent(metric->interval[0]) + " .. " + percent(metric->interval[1]);
    verdict = verdict_word(metric->verdict);
  } else if (std::isfinite(line.target) && line.target != 0 && std::isfinite(line.fresh)) {
    difference = percent(line.fresh / line.target - 1);
  }
  std::string spreads;
  if (with_spreads)
    spreads =
        fmt::format(" {:>9}", line.metric && line.metric->spread > 0
                                  ? fmt::format("{:+.2f}", line.metric->difference / line.metric->spread)
                                  : "-");
  return fmt::format("  {:<{}} {:>10} {:>10} {:>10} {:>9}{}  {:>18}  {}\n", name_without_unit(line.name),
                     name_width, quantity(line.target, line.name), quantity(line.fitted, line.name),
                     quantity(line.fresh, line.name), difference, spreads, interval, verdict);
}

std::string statistics_table(const ResultDocument& result, bool all) {
  const std::vector<Line> lines = statistic_lines(result);
  if (lines.empty()) return "";
  const auto fitted = [](const Line& line) { return !line.held_out; };
  const auto held_out = [](const Line& line) { return line.held_out; };
  const std::string of_map = "Statistics of the terms at the focus, by " + result.model;
  std::vector<Section> sections;
  if (all) {
    sections = {section_of(only_map(result) ? of_map : "Fitted statistics", lines, fitted),
                section_of("Held-out statistics, judged but not fitted", lines, held_out)};
  } else {
    sections = {section_of(only_map(result) ? of_map
                           : result.map     ? "Statistics of the part at the focus"
                                            : "Fitted statistics at the focus",
                           lines, [](const Line& l) { return l.at_focus; }),
                worst_section("Fitted in other planes", kWorstFitted, lines,
                              [](const Line& l) { return !l.held_out && !l.at_focus; }),
                worst_section("Held out, judged but not fitted", kWorstHeldOut, lines, held_out)};
  }

  const bool with_spreads = result.map && !only_map(result);
  std::size_t width = 20;
  for (const Section& section : sections)
    for (const Line& line : section.lines) width = std::max(width, name_without_unit(line.name).size());
  const double confidence = result.confidence;
  const std::string interval =
      confidence > 0 ? fmt::format("{:.3g} % interval [%]", 100 * (2 * confidence - 1)) : "interval [%]";
  std::string out = fmt::format("\n  {:<{}} {:>10} {:>10} {:>10} {:>9}{}  {:>18}  {}\n", "", width, "target",
                                "fitted", by_waves(result) ? "fresh grid" : "fresh rays", "diff. [%]",
                                with_spreads ? fmt::format(" {:>9}", "spreads") : "", interval, "verdict");
  for (const Section& section : sections) {
    if (section.lines.empty()) continue;
    out += section.title + "\n";
    for (const Line& line : section.lines) out += table_row(line, width, with_spreads);
  }
  return out;
}

// Light's answer, where the fit's own metrics are not light's.
std::string light_table(const ResultDocument& result, bool all) {
  const auto& light = result.light;
  if (!light) return "";
  if (light->metrics.empty())
    return light->obstacle.empty() ? "" : "\n" + paragraph("Light", "no answer: " + light->obstacle);
  std::string out = fmt::format(
      "\nThe same surface in light, by diffraction{}\n  {:<28} {:>10} {:>10} {:>9}  {}\n",
      light->decides ? " (this decides)" : "", "", light->theory, "surface", "diff. [%]", "verdict");
  const EquivalenceMetric* worst = worst_of(light->metrics);
  for (const EquivalenceMetric& metric : light->metrics) {
    if (!all && &metric != worst && (!is_at_focus(metric.name) || metric.held_out)) continue;
    out += fmt::format("  {:<28} {:>10} {:>10} {:>9}  {}{}\n", name_without_unit(metric.name),
                       quantity(metric.target, metric.name), quantity(metric.model, metric.name),
                       percent(metric.difference), verdict_word(metric.verdict),
                       &metric == worst ? ", the worst of all" : "");
  }
  return out;
}

// What differences mean, and whether the margin can see the roughness.
std::string footnotes(const ResultDocument& result) {
  std::string out;
  const bool in_light =
      std::any_of(result.metrics.begin(), result.metrics.end(),
                  [](const EquivalenceMetric& m) { return std::isfinite(m.tolerance_share); });
  const auto of_light_alone = [](const EquivalenceMetric& m) {
    return m.name == "strehl" || m.name.starts_with("mtf@");
  };
  if (in_light)
    out += "\n" +
           paragraph("diff.",
                     fmt::format("of an ee radius: p less the share of light inside the target's radius, "
                                 "over max(r dE/dr, {}); of ee_within and ensquared_within: the share less "
                                 "its target, over {}{}",
                                 kFlattestCurve, kFlattestCurve,
                                 std::any_of(result.metrics.begin(), result.metrics.end(), of_light_alone)
                                     ? fmt::format("; of strehl and mtf: less the target, over the target or "
                                                   "{}, whichever is larger",
                                                   kFlattestCurve)
                                     : ""));
  if (result.map && result.spread.worst())
    out +=
        paragraph("spreads", "diff. over the standard deviation of it among mirrors of this specification");
  if (result.perfect)
    out += paragraph(
        "Perfect",
        fmt::format("the perfect mirror's worst statistic in light{} is {:.3g} tolerances away ({})",
                    result.perfect->mismatch < 1 ? "" : " in focus", result.perfect->mismatch,
                    name_without_unit(result.perfect->statistic)));
  return out;
}

std::string spectrum_table(const ResultDocument& result) {
  if (result.spectrum.empty()) return "";
  std::string out = fmt::format("\nPSD bins of the term surface\n  {:<24} {:>14} {:>14} {:>9}\n",
                                "band [cycles/m]", "target [m^4]", "fitted [m^4]", "diff. [%]");
  for (const SpectrumBin& bin : result.spectrum)
    out += fmt::format("  {:<24} {:>14.4g} {:>14.4g} {:>9}\n",
                       fmt::format("{:.4g} .. {:.4g}", bin.low, bin.high), bin.target, bin.fitted,
                       percent(bin.fitted / bin.target - 1));
  return out;
}

}  // namespace

std::string summary_table(const ResultDocument& result, bool all) {
  std::string out = headline(result);
  out += std::string(kColumns, '-') + "\n";
  if (!result.title.empty()) out += paragraph("Study", result.title);
  out += scene_lines(result) + fit_lines(result) + statistics_table(result, all) + map_light_table(result) +
         light_table(result, all) + footnotes(result) + spectrum_table(result) +
         (result.character ? character_table(*result.character) : "");
  if (!result.warnings.empty()) out += "\n";
  for (const Warning& warning : result.warnings)
    out += paragraph("WARNING", "[" + warning.code + "] " + warning.message);
  return out;
}

}  // namespace aberfit
