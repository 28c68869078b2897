// This file makes the page of "check", a study before its fit.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "aberfit/core/constants.h"
#include "aberfit/core/units.h"
#include "aberfit/method/constants.h"
#include "aberfit/report/documents.h"
#include "paragraph.h"

namespace aberfit {
using namespace internal;

namespace {

// A table of labels and values.
class Rows {
 public:
  void add(std::string label, std::string value) { table_.add({std::move(label), std::move(value)}); }
  Page::Table table() { return std::move(table_); }

 private:
  Page::Table table_{"", {}, "ll"};
};

// Two digits suffice, because a time measured once is no more precise.
std::string time_text(double seconds) {
  if (seconds < 0.1) return fmt::format("{:.2g} ms", 1000 * seconds);
  if (seconds < 99.5) return fmt::format("{:.2g} s", seconds);
  return seconds < 5970 ? fmt::format("{:.2g} min", seconds / 60) : fmt::format("{:.2g} h", seconds / 3600);
}

std::string bytes_text(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.0f} MB", bytes / 1e6) : fmt::format("{:.1f} GB", bytes / 1e9);
}

std::string ray_error_text(double ee90_radius, double ee50_error, double ee90_error) {
  return fmt::format("{}, wrong by {:+.3g} %; ee50 by {:+.3g} %", metres_text(ee90_radius), 100 * ee90_error,
                     100 * ee50_error);
}

// Adds the mean spot in the quantities of optical specifications.
void add_light(Rows* rows, const SpecifiedLight& light) {
  constexpr double kArcsec = 648000 / kPi;
  std::string widths, sky, shares;
  for (const SpecifiedValue& one : light.values) {
    const auto add = [&](std::string* to, const std::string& value) {
      const std::string name = one.key.substr(0, one.key.find('_'));
      *to += fmt::format("{}{} {}", to->empty() ? "" : ", ", name, value);
    };
    if (one.key == "hew") continue;  // equals ee50_diameter
    if (one.is_width) {
      add(&widths, metres_text(one.value));
      add(&sky, fmt::format("{:.3g}", one.value / light.focal_length * kArcsec));
    } else {
      add(&shares, fmt::format("{:.4g}", one.value));
    }
  }
  if (!widths.empty()) rows->add("mean PSF, diameters", widths), rows->add("  on the sky [arcsec]", sky);
  if (!shares.empty()) rows->add("  its ratios", shares);
  if (light.lines.empty()) return;
  const auto line = [](const SpecifiedLight::Line& one) {
    return fmt::format("{} ee50 {}, ee80 {}", metres_text(one.wavelength), metres_text(one.ee50_diameter),
                       metres_text(one.ee80_diameter));
  };
  const auto [shortest, longest] =
      std::minmax_element(light.lines.begin(), light.lines.end(),
                          [](const auto& a, const auto& b) { return a.wavelength < b.wavelength; });
  rows->add("  its lines",
            fmt::format("{}, from {} to {}", light.lines.size(), line(*shortest), line(*longest)));
}

// Adds R, kappa and GHS of the specification, with both verdicts side by side.
void add_scene(Rows* rows, const CheckReport& report) {
  const SceneFacts& scene = *report.scene;
  const SceneNumbers& n = scene.numbers;
  const ModelErrors& e = *scene.errors;
  rows->add("RMS height", metres_text(n.rms_height));
  rows->add("RMS slope per axis", format_quantity(n.rms_slope_per_axis, Dimension::kAngle));
  rows->add("spot scale sigma_f", metres_text(report.focal_sigma));
  rows->add("slope-carrying modes N_eff", fmt::format("{:.0f}", n.n_eff));
  if (const StatisticSpread* worst = scene.spread.worst())
    rows->add("spread of single mirrors", spread_words(*worst) + ", one standard deviation");
  rows->add("g = 4 pi sigma/lambda", fmt::format("{:.3g}, TIS {:.3g}", n.g, n.tis));
  rows->add("kappa (rays from 0.85 up)", fmt::format("{:.3g}", n.kappa));
  rows->add("Airy ee90", metres_text(n.airy_ee90));
  rows->add("ee90 by Harvey-Shack (waves)",
            metres_text(e.ghs.ee90) +
                fmt::format(", ee50 {}, ee80 {}", metres_text(e.ghs.ee50), metres_text(e.ghs.ee80)));
  add_light(rows, scene.mean_light);
  rows->add("ee90 by rays", ray_error_text(e.rays.ee90, e.ray_ee50, e.ray_ee90));
  rows->add("R of the paper", fmt::format("{:.4g}", n.paper_ratio_r));
  rows->add("model needed", scene.needed);
  rows->add("why", scene.reason);
  rows->add("models used", fmt::format("targets {}, surface {}", scene.theory, scene.model));
  if (report.too_simple)
    rows->add("", "simpler than needed" +
                      (report.light_decides
                           ? "; `fit` will judge by " + scene.needed
                           : ", because the study names it; `fit` will judge by theory `" + scene.theory +
                                 "` and report the result of wave optics beside it"));
}

std::string terms_text(const CheckedTerms& terms) {
  std::string text = fmt::format("{}", terms.count);
  if (terms.automatic && terms.order > 0) text += fmt::format(", Zernikes to n = {} at first", terms.order);
  if (terms.segments > 0) text += fmt::format(", with the errors of {} segments", terms.segments);
  return text + fmt::format(" ({:.2f} % of the height variance)", 100 * terms.captured);
}

// The errors of the theory, which the verdict neglects for any surface.
std::string theory_text(const TheoryError& error) {
  const std::string angle = std::isfinite(error.small_angle)
                                ? fmt::format("{:.2g} %", 100 * error.small_angle)
                                : "an unknown fraction";
  constexpr double kNext = 1e-6;  // error of the quadrature
  const std::string beyond = error.beyond_ten_degrees < kNext
                                 ? "less than 0.0001 %"
                                 : fmt::format("{:.2g} %", 100 * error.beyond_ten_degrees);
  return fmt::format("radii: {} from the small-angle approximation; {} of the energy goes beyond 10 degrees",
                     angle, beyond);
}

// Largest distance of the statistics from the focus; the FWHM of a ring counts half of its width.
std::string planes_text(const CheckReport& report) {
  std::optional<double> reach;
  const auto seen = [&reach](double dz) { reach = std::max(reach.value_or(0), std::abs(dz)); };
  for (const std::vector<Target>* targets : {&report.fitted, &report.held_out})
    for (const Target& target : *targets)
      if (const auto dz = plane_of_light(target.statistic))
        seen(*dz);
      else if (kind_of(target.statistic).plane == FocalPlane::kThrough)
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
    return report.cells ? fmt::format("none: wave optics on a grid of {:.0f} points across, judged on {:.0f}",
                                      report.cells->fit, report.cells->verdict)
                        : "none: wave optics, but no grid is fine enough";
  return report.automatic_rays ? fmt::format("the fit chooses: at least {} for so many terms", report.rays)
                               : fmt::format("{}", report.rays);
}

void add_cost(Rows* rows, const CheckReport& report) {
  if (!report.cost) return;
  const CheckedCost& cost = *report.cost;
  if (cost.bytes > 0)
    rows->add("memory of `fit`",
              fmt::format("{}: {} residuals on {} {}", bytes_text(cost.bytes), cost.residuals, cost.points,
                          report.model == FocusModel::kWaves ? "grid points" : "rays"));
  if (!cost.iteration_seconds) return rows->add("time of `fit`", "not measured: " + cost.obstacle);
  const std::string more = cost.at_least ? "more than " : "";
  const double each = *cost.iteration_seconds;
  rows->add("one iteration", fmt::format("{}{} on {}, just measured", more, time_text(each),
                                         plural(report.threads, "thread")));
  const std::string verdict =
      cost.verdict_seconds ? ", and " + time_text(*cost.verdict_seconds) + " for the verdict" : "";
  rows->add(
      "time of `fit`",
      fmt::format("{} to {} iterations: {}{} to {}{}; realisations to compare with and "
                  "pictures come on top",
                  law::kFewIterations, law::kManyIterations, more, time_text(law::kFewIterations * each),
                  time_text(law::kManyIterations * each), verdict));
}

void add_answers(Page* page, const CheckReport& report) {
  const auto say = [&](const char* label, std::string text) {
    page->answers.push_back({label, std::move(text)});
  };
  say("What it answers",
      "Nothing is fitted or judged here. The page shows the focus that the study predicts, the model that it "
      "needs, and the size and time of a fit.");
  if (report.scene) {
    say("How certain", "The focus is the mean over all mirrors of this specification. " +
                           (report.scene->spread.worst()
                                ? "Single mirrors vary about it with a standard deviation of up to " +
                                      spread_words(*report.scene->spread.worst()) + "."
                                : std::string("Single mirrors vary about it.")));
    say("What it rests on",
        "Harvey-Shack theory for a stationary, isotropic, Gaussian roughness with the given PSD. Geometric "
        "rays stand beside it for comparison.");
  }
  say("What would change it",
      "The roughness, the aperture and the wavelength set the focus; `target`, `terms` and `equivalence` set "
      "the size of the fit.");
  say("What to do next", "`aberfit fit` with the same study finds the terms and judges them.");
}

}  // namespace

Page page_of(const CheckReport& report) {
  Page page;
  page.title = report.title;
  add_answers(&page, report);
  Rows rows;
  rows.add("f-number", fmt::format("f/{:.3g}", report.mirror.f_number));
  rows.add("rim above vertex", metres_text(report.mirror.rim_sag_max));
  if (report.scene) {
    add_scene(&rows, report);
    if (report.theory_error) rows.add("error of the wave theory", theory_text(*report.theory_error));
  } else {
    rows.add("models", fmt::format("targets {}, surface {}: {}", report.theory, to_string(report.model),
                                   report.reason));
  }
  rows.add("terms", terms_text(report.terms));
  if (report.shares) rows.add("band", report.shares->reason);
  rows.add("statistics", statistics_text(report));
  rows.add("rays", rays_text(report));
  add_cost(&rows, report);
  page.parts.push_back(rows.table());
  page.warnings = report.warnings;
  return page;
}

Page page_of(const MapCheckReport& report) {
  Page page;
  page.title = report.title;
  page.answers = {{"What it answers", "Nothing is fitted here. The page shows what the map holds."},
                  {"What it rests on", "The measured heights, and the terms and band of the study."},
                  {"What to do next", "`aberfit fit` with the same study fits the terms to the map."}};
  Rows rows;
  rows.add("map", fmt::format("{} x {} points, {} valid, pitch {}", report.columns, report.rows, report.valid,
                              pitches_text(report.pitch_x, report.pitch_y)));
  rows.add("terms", fmt::format("{} by least squares", report.terms));
  if (report.shares) rows.add("band", report.shares->reason);
  page.parts.push_back(rows.table());
  page.warnings = report.warnings;
  return page;
}

}  // namespace aberfit
