#include <fmt/format.h>

#include <cmath>

#include "aberfit/report/documents.h"
#include "paragraph.h"
#include "verdict_words.h"

namespace aberfit {
using namespace internal;

namespace {

// The statistic that is farthest from its target.
std::string headline_of(const TraceReport& report) {
  const TracedStatistic* worst = nullptr;
  const auto off = [](const TracedStatistic& one) { return std::abs(one.value / one.target - 1); };
  long compared = 0;
  for (const TracedStatistic& one : report.statistics) {
    compared += std::isfinite(off(one));
    if (std::isfinite(off(one)) && (!worst || off(one) > off(*worst))) worst = &one;
  }
  if (!worst) return "";
  return fmt::format("The surface is within {:.2g} % of its targets in {} ({} is farthest)",
                     100 * off(*worst), plural(compared, "statistic"),
                     name_without_unit(statistic_name(worst->statistic)));
}

}  // namespace

Page page_of(const TraceReport& report) {
  Page page;
  page.title = report.title;
  page.headline = headline_of(report);
  const bool waves = report.model == FocusModel::kWaves;
  page.answers.push_back({"How certain",
                          "The numbers are those of one surface; the targets are means of its specification, "
                          "from which single mirrors differ."});
  page.answers.push_back({"What it rests on", (waves ? "The surface is diffracted on a grid"
                                                     : "Geometric rays are traced from the surface") +
                                                  std::string(", and nothing is fitted. ") + report.reason});
  page.answers.push_back({"What would change it",
                          "Other coefficients (`--coefficients`), or without them another seed: the surface "
                          "is then a random one of the roughness."});
  page.answers.push_back({"What to do next",
                          "`aberfit fit` finds a surface that meets the targets; `aberfit verify` compares "
                          "the mean of many surfaces with them."});
  page.say("Model",
           fmt::format("{}, {} {} ({} lost), {}", to_string(report.model), report.rays,
                       waves ? "grid points" : "rays", report.lost_rays, plural(long(report.terms), "term")));
  Page::Table table{"", {"statistic", "surface", "target", "diff. [%]"}, "lrrr"};
  for (const TracedStatistic& traced : report.statistics) {
    const std::string name = statistic_name(traced.statistic);
    const Dimension dimension = dimension_of_name(name);
    table.add({name_without_unit(name), four_digits(traced.value, dimension),
               four_digits(traced.target, dimension), signed_percent(traced.value / traced.target - 1)});
  }
  page.parts.push_back(std::move(table));
  page.warnings = report.warnings;
  return page;
}

}  // namespace aberfit
