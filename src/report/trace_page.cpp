#include <fmt/format.h>

#include "aberfit/report/documents.h"
#include "paragraph.h"
#include "verdict_words.h"

namespace aberfit {
using namespace internal;

Page page_of(const TraceReport& report) {
  Page page;
  page.title = report.title;
  const bool waves = report.model == FocusModel::kWaves;
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
