// This file makes the page of a verification and describes its facts.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/core/text.h"
#include "aberfit/report/documents.h"
#include "facts.h"
#include "paragraph.h"
#include "verdict_words.h"

namespace aberfit {
using namespace internal;

namespace {

std::string convention_word(Convention convention) {
  return convention == Convention::kPaper ? "paper" : "physical";
}

// The worst statistic of a comparison that is not equivalent: nearest to its margin or farthest beyond it.
std::string worst(const std::vector<EquivalenceMetric>& metrics) {
  const EquivalenceMetric* found = nullptr;
  const auto reach = [](const EquivalenceMetric& m) {
    return std::max(std::abs(m.interval[0]), std::abs(m.interval[1]));
  };
  for (const EquivalenceMetric& m : metrics)
    if (m.verdict != Verdict::kEquivalent && (!found || reach(m) > reach(*found))) found = &m;
  return found ? fmt::format(" ({} {:+.2f} %)", name_without_unit(found->name), 100 * found->difference) : "";
}

std::string light_word(const VerifyReport& report) {
  return report.light_obstacle.empty() ? upper_case(to_string(report.light_verdict)) + worst(report.light)
                                       : "not computed";
}

// Verdict of the deciding theory, and that of the other.
std::string headline(const VerifyReport& report) {
  const std::string rays = upper_case(to_string(report.rays_verdict)) + worst(report.metrics);
  const std::string first =
      report.rays_decide ? rays + " by geometric rays" : light_word(report) + " by wave optics";
  const std::string second =
      report.rays_decide ? "by wave optics " + light_word(report) : "by geometric rays " + rays;
  return fmt::format("{}; {}", first, second);
}

// "by wave optics ee50_radius -0.18 % (-0.43 .. +0.07 %)", the statistic nearest to the margin or beyond it.
std::string farthest(const std::vector<EquivalenceMetric>& metrics, const char* theory) {
  const EquivalenceMetric* worst = worst_of(metrics);
  if (!worst) return "";
  return fmt::format("{} {} {:+.2f} % ({:+.2f} .. {:+.2f} %)", theory, name_without_unit(worst->name),
                     100 * worst->difference, 100 * worst->interval[0], 100 * worst->interval[1]);
}

std::string by_how_much(const VerifyReport& report) {
  const std::string rays = farthest(report.metrics, "by geometric rays");
  const std::string waves = farthest(report.light, "by wave optics");
  return fmt::format(
      "The largest differences from theory, with their intervals: {}{}{}. The margin is {:.3g} %.", rays,
      rays.empty() || waves.empty() ? "" : "; ", waves, 100 * report.margin);
}

// Says what the verdict means for a fit of the same study.
std::string next_step(const VerifyReport& report) {
  if (report.draws == 0)
    return "One surface differs from the mean of its specification. Without `--coefficients` the mean of "
           "many "
           "surfaces is compared.";
  switch (report.verdict) {
    case Verdict::kEquivalent:
      return "The theory describes this roughness, so its values can be the targets of `aberfit fit`.";
    case Verdict::kDifferent:
      return "Before a fit, look in the tables for the statistics that differ: their targets would not be "
             "those of such mirrors.";
    default:
      return "More realisations (`verify.draws`) decide it.";
  }
}

std::string judged_text(const VerifyReport& report) {
  const double level = 100 * report.margin;
  return report.draws > 0
             ? fmt::format("the mean PSF of {} random surfaces, at a margin of {:.3g} %, convention {}",
                           report.draws, level, convention_word(report.convention))
             : fmt::format("the given surface by {} rays, at a margin of {:.3g} %, convention {}",
                           report.rays, level, convention_word(report.convention));
}

Page::Table metric_table(const std::string& title, const char* target, const char* model,
                         const std::vector<EquivalenceMetric>& metrics, const std::vector<double>* theory) {
  Page::Table table{title, {"statistic", target, model, "diff. [%]", "interval [%]", "verdict"}, "lrrrrl"};
  if (theory) table.heads.insert(table.heads.begin() + 1, "theory"), table.align.insert(1, "r");
  for (std::size_t k = 0; k < metrics.size(); ++k) {
    const EquivalenceMetric& m = metrics[k];
    const Dimension dimension = dimension_of_name(m.name);
    std::vector<std::string> cells = {name_without_unit(m.name)};
    if (theory) cells.push_back(four_digits(theory->at(k), dimension));
    for (const double value : {m.target, m.model}) cells.push_back(four_digits(value, dimension));
    cells.push_back(fmt::format("{:+.2f}", 100 * m.difference));
    cells.push_back(fmt::format("{:+.2f} .. {:+.2f}", 100 * m.interval[0], 100 * m.interval[1]));
    cells.push_back(verdict_word(m.verdict));
    table.add(std::move(cells), m.verdict == Verdict::kEquivalent ? Page::Tone::kPlain : tone_of(m.verdict));
  }
  return table;
}

// A comparison of two branches, whose names are its keys.
struct Branches {
  EquivalenceMetric metric;
  bool in_light = false;
  double theory = kNaN;
};

void describe(Facts& facts, const Branches& of) {
  const EquivalenceMetric& m = of.metric;
  facts.where(!of.in_light, "theory", of.theory, "Value by geometric Harvey-Shack in closed form.");
  facts.where(!of.in_light, "harvey_shack", m.target, "Value by rays that the roughness perturbs.");
  facts.where(!of.in_light, "aberration_terms", m.model, "Value by rays traced from the surfaces of terms.");
  facts.where(of.in_light, "ghs", m.target, "Value by generalised Harvey-Shack.");
  facts.where(of.in_light, "waves", m.model, "Value by diffraction of the surfaces of terms.");
  facts("relative_difference", m.difference,
        "Judged difference: aberration_terms over harvey_shack (or waves over ghs) minus 1; encircled energy "
        "by fractions.");
  facts("standard_error", m.standard_error, "Sampling error of the difference.");
  facts("interval", m.interval, "Confidence interval of the difference.");
  facts("verdict", m.verdict, "equivalent, different or undecided.");
}

std::vector<std::string> metric_names(const std::vector<EquivalenceMetric>& metrics) {
  std::vector<std::string> names;
  for (const EquivalenceMetric& metric : metrics) names.push_back(metric.name);
  return names;
}

}  // namespace

void internal::describe(Facts& facts, const VerifyReport& report) {
  std::vector<Branches> rays, waves;
  for (std::size_t k = 0; k < report.metrics.size(); ++k)
    rays.push_back({report.metrics[k], false, report.theory.at(k)});
  for (const EquivalenceMetric& metric : report.light) waves.push_back({metric, true});
  facts("convention", convention_word(report.convention),
        "physical: a ray turns by twice the slope; paper: by the slope.");
  facts("verdict", report.verdict, "Verdict of the theory that decides.");
  facts("decided_by", report.rays_decide ? "rays" : "light",
        "Theory that decides: rays or light (wave optics).");
  facts("draws", report.draws, "Number of realisations in each mean; 0: a given surface.");
  facts("margin", report.margin, "Largest allowed distance of the intervals' ends from 0.");
  facts("scene", report.scene, "The specification, and the models that it needs.");
  facts.keyed("statistics", metric_names(report.metrics), rays, "Statistics by rays, by name.");
  facts.object("light", "The same comparison by wave optics.", [&](Facts& light) {
    light("verdict", report.light_verdict, "Verdict by wave optics.");
    light("draws", report.light_draws, "Number of realisations in each mean.");
    light.where(!report.light_obstacle.empty(), "obstacle", report.light_obstacle,
                "Reason why there is none.");
    light.keyed("statistics", metric_names(report.light), waves, "Statistics by wave optics, by name.");
  });
  facts("warnings", report.warnings, "Warnings that the reader should know.");
}

Page page_of(const VerifyReport& report) {
  Page page;
  page.headline = headline(report);
  page.tone = tone_of(report.verdict);
  page.title = report.title;
  page.answers = {
      {"By how much", by_how_much(report)},
      {"How certain",
       report.draws > 0
           ? fmt::format("Intervals include the sampling error of {} realisations, estimated from groups of "
                         "them.",
                         report.draws)
           : "Intervals include the sampling error of the rays."},
      {"What it rests on",
       "Realisations of a stationary, isotropic, Gaussian roughness with the given PSD, by geometric rays "
       "and by diffraction, are compared with Harvey-Shack theory."},
      {"What would change it",
       "More realisations (`verify.draws`) narrow the intervals; `equivalence.margin` sets the allowed "
       "difference."},
      {"What to do next", next_step(report)}};
  page.say("Judged", judged_text(report));
  page.parts.push_back(metric_table("By rays: Harvey-Shack (perturbed rays) and aberration terms (traced)",
                                    "Harvey-Shack", "terms", report.metrics, &report.theory));
  if (!report.light.empty())
    page.parts.push_back(metric_table(
        fmt::format("By wave optics: generalised Harvey-Shack{} and the diffraction of the terms{}; EE is "
                    "compared by energy fractions",
                    report.convention == Convention::kPaper ? " of half the heights" : "",
                    report.light_draws > 0 ? fmt::format(", {} realisations", report.light_draws) : ""),
        "GHS", "waves", report.light, nullptr));
  page.warnings = report.warnings;
  return page;
}

}  // namespace aberfit
