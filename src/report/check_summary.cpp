#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "aberfit/core/constants.h"
#include "aberfit/core/units.h"
#include "aberfit/method/constants.h"
#include "aberfit/report/check_report.h"
#include "paper_table.h"
#include "paragraph.h"

namespace aberfit {
using namespace internal;

namespace {

std::string row(const std::string& label, const std::string& value) {
  constexpr std::size_t kValues = 37;  // column
  return fmt::format("  {:<34} {}\n", label, wrapped(value, kColumns - kValues, kValues));
}
std::string heading(const std::string& title) { return title.empty() ? "" : title + "\n\n"; }

// Two digits: a time that was measured once has no more.
std::string time_text(double seconds) {
  if (seconds < 0.1) return fmt::format("{:.2g} ms", 1000 * seconds);
  if (seconds < 99.5) return fmt::format("{:.2g} s", seconds);
  return seconds < 5970 ? fmt::format("{:.2g} min", seconds / 60) : fmt::format("{:.2g} h", seconds / 3600);
}

std::string bytes_text(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.0f} MB", bytes / 1e6) : fmt::format("{:.1f} GB", bytes / 1e9);
}

std::string error_row(const char* label, double ee90_radius, double ee50_error, double ee90_error) {
  return row(label, fmt::format("{}: off by {:+.3g} %; ee50 by {:+.3g} %", metres_text(ee90_radius),
                                100 * ee90_error, 100 * ee50_error));
}

// The mean light as specifications ask for it.
std::string light_rows(const SpecifiedLight& light) {
  constexpr double kArcsec = 648000 / kPi;
  std::string widths, sky, shares;
  for (const SpecifiedValue& one : light.values) {
    const auto add = [&](std::string* to, const std::string& value) {
      const std::string name = one.key.substr(0, one.key.find('_'));
      *to += fmt::format("{}{} {}", to->empty() ? "" : ", ", name, value);
    };
    if (one.key == "hew") continue;  // ee50_diameter
    if (one.is_width) {
      add(&widths, metres_text(one.value));
      add(&sky, fmt::format("{:.3g}", one.value / light.focal_length * kArcsec));
    } else {
      add(&shares, fmt::format("{:.4g}", one.value));
    }
  }
  std::string text;
  if (!widths.empty()) text += row("mean light across", widths) + row("  on the sky [arcsec]", sky);
  if (!shares.empty()) text += row("  its shares", shares);
  if (light.lines.empty()) return text;
  const auto line = [](const SpecifiedLight::Line& one) {
    return fmt::format("{} ee50 {}, ee80 {}", metres_text(one.wavelength), metres_text(one.ee50_diameter),
                       metres_text(one.ee80_diameter));
  };
  const auto [shortest, longest] =
      std::minmax_element(light.lines.begin(), light.lines.end(),
                          [](const auto& a, const auto& b) { return a.wavelength < b.wavelength; });
  return text + row("  its lines",
                    fmt::format("{}, from {} to {}", light.lines.size(), line(*shortest), line(*longest)));
}

// How far mirrors differ: in the worst statistic, and in those of the focus that have a short name.
std::string spread_rows(const MirrorSpread& spread) {
  const StatisticSpread* worst = spread.worst();
  if (!worst) return "";
  return row("single mirrors differ by", spread_words(*worst) + ", one standard deviation, at most");
}

// R, kappa and GHS of the specification, with both verdicts side by side.
std::string scene_rows(const CheckReport& report) {
  const SceneFacts& scene = *report.scene;
  const SceneNumbers& n = scene.numbers;
  const ModelErrors& e = *scene.errors;
  std::string text = row("RMS height", metres_text(n.rms_height));
  text += row("RMS slope per axis", format_quantity(n.rms_slope_per_axis, Dimension::kAngle));
  text += row("spot scale sigma_f", metres_text(report.focal_sigma));
  text += row("slope-carrying modes N_eff", fmt::format("{:.0f}", n.n_eff));
  text += spread_rows(scene.spread);
  text += row("g = 4 pi sigma/lambda", fmt::format("{:.3g}, TIS {:.3g}", n.g, n.tis));
  text += row("kappa (rays from 0.85 up)", fmt::format("{:.3g}", n.kappa));
  text += row("Airy ee90", metres_text(n.airy_ee90));
  text += row("ee90 by Harvey-Shack (waves)",
              metres_text(e.ghs.ee90) +
                  fmt::format(", ee50 {}, ee80 {}", metres_text(e.ghs.ee50), metres_text(e.ghs.ee80)));
  text += light_rows(scene.mean_light);
  text += error_row("ee90 by rays", e.rays.ee90, e.ray_ee50, e.ray_ee90);
  text += row("R of the paper", fmt::format("{:.4g}", n.paper_ratio_r));
  text += row("  its verdict (R >> 1: rays)", paper_verdict(n.paper_ratio_r));
  text += row("  ours", scene.needed);
  text += row("why", scene.reason);
  text += row("models used", fmt::format("targets {}, surface {}", scene.theory, scene.model));
  if (report.too_simple)
    text += row(
        "", "simpler than needed" +
                (report.light_decides ? ": the verdict of `fit` will be on " + scene.needed
                                      : ", as the study names it: the verdict of `fit` will be on theory `" +
                                            scene.theory + "`, with what light says beside it"));
  return text;
}

std::string terms_text(const CheckedTerms& terms) {
  std::string text = fmt::format("{}", terms.count);
  if (terms.automatic && terms.order > 0)
    text += fmt::format(", Zernikes to n = {} to begin with", terms.order);
  if (terms.segments > 0) text += fmt::format(", with the errors of {} segments", terms.segments);
  return text + fmt::format(" ({:.2f} % of the height variance)", 100 * terms.captured);
}

// What the verdict leaves out whatever the surface, beside the margin that it is given with.
std::string theory_text(const TheoryError& error) {
  const std::string angle = std::isfinite(error.small_angle)
                                ? fmt::format("{:.2g} %", 100 * error.small_angle)
                                : "an unknown share";
  constexpr double kNext = 1e-6;  // to nothing: what quadrature leaves
  const std::string beyond = error.beyond_ten_degrees < kNext
                                 ? "less than 0.0001 %"
                                 : fmt::format("{:.2g} %", 100 * error.beyond_ten_degrees);
  return fmt::format("{} of radii by small angles, {} of the light beyond 10 degrees", angle, beyond);
}

// How far from the focus statistics are, those of a ring half of its width.
std::string planes_text(const CheckReport& report) {
  std::optional<double> reach;
  const auto seen = [&reach](double dz) { reach = std::max(reach.value_or(0), std::abs(dz)); };
  for (const std::vector<Target>* targets : {&report.fitted, &report.held_out})
    for (const Target& target : *targets)
      if (const auto dz = plane_of_light(target.statistic))
        seen(*dz);
      else if (std::holds_alternative<RingFwhm>(target.statistic))
        seen(0.5 * target.value);
  if (!reach) return "";
  return *reach > 0 ? ", in planes up to " + metres_text(*reach) + " from the focus" : ", in the focus";
}

std::string statistics_text(const CheckReport& report) {
  return fmt::format("{} fitted, {} guides, {} held out{}; targets: {}", report.statistics.fitted,
                     report.statistics.guides, report.statistics.held_out, planes_text(report),
                     report.theory);
}

std::string rays_text(const CheckReport& report) {
  if (report.model == FocusModel::kWaves)
    return report.cells ? fmt::format("none: waves on a grid of {:.0f} cells across, judged on {:.0f}",
                                      report.cells->fit, report.cells->verdict)
                        : "none: waves, but no grid is fine enough";
  return report.automatic_rays ? fmt::format("chosen by the fit: {} or more for so many terms", report.rays)
                               : fmt::format("{}", report.rays);
}

std::string cost_rows(const CheckReport& report) {
  if (!report.cost) return "";
  const CheckedCost& cost = *report.cost;
  std::string rows;
  if (cost.bytes > 0)
    rows += row("memory of `fit`",
                fmt::format("{}: {} residuals on {} {}", bytes_text(cost.bytes), cost.residuals, cost.points,
                            report.model == FocusModel::kWaves ? "cells" : "rays"));
  if (!cost.iteration_seconds) return rows + row("time of `fit`", "not measured: " + cost.obstacle);
  const std::string more = cost.at_least ? "more than " : "";
  const double each = *cost.iteration_seconds;
  rows += row("one iteration", fmt::format("{}{} on {}, measured just now", more, time_text(each),
                                           plural(report.threads, "thread")));
  const std::string verdict =
      cost.verdict_seconds ? ", and " + time_text(*cost.verdict_seconds) + " for the verdict" : "";
  return rows +
         row("time of `fit`", fmt::format("{} to {} iterations: {}{} to {}{}", law::kFewIterations,
                                          law::kManyIterations, more, time_text(law::kFewIterations * each),
                                          time_text(law::kManyIterations * each), verdict));
}

}  // namespace

std::string summary_table(const CheckReport& report) {
  std::string text = heading(report.title);
  text += row("f-number", fmt::format("f/{:.3g}", report.mirror.f_number));
  text += row("rim above vertex", metres_text(report.mirror.rim_sag_max));
  const std::string theory =
      report.theory_error ? row("error of the wave theory", theory_text(*report.theory_error)) : "";
  text += report.scene ? scene_rows(report) + theory
                       : row("models", fmt::format("targets {}, surface {}: {}", report.theory,
                                                   to_string(report.model), report.reason));
  text += row("terms", terms_text(report.terms));
  if (report.shares) text += row("band", report.shares->reason);
  text += row("statistics", statistics_text(report));
  text += row("rays", rays_text(report)) + cost_rows(report);
  text += warning_lines(report.warnings);
  if (report.paper_table) text += fmt::format("\n{}", summary_table(*report.paper_table));
  return text;
}

std::string summary_table(const MapCheckReport& report) {
  std::string text = heading(report.title);
  text += row("map", fmt::format("{} x {} points, {} valid, pitch {}", report.columns, report.rows,
                                 report.valid, pitches_text(report.pitch_x, report.pitch_y)));
  text += row("terms", fmt::format("{} by least squares", report.terms));
  if (report.shares) text += row("band", report.shares->reason);
  return text + warning_lines(report.warnings);
}

}  // namespace aberfit
