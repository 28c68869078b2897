#include "aberfit/report/sweep_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "aberfit/core/constants.h"
#include "aberfit/core/text.h"
#include "aberfit/core/units.h"
#include "aberfit/focus/statistic.h"
#include "aberfit/report/documents.h"
#include "csv_field.h"
#include "short_labels.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr std::size_t kMostToldFailures = 5;

std::string csv_value(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

std::size_t place_axes(const SweepReport& report) { return report.axes.size() - (report.has_seeds ? 1 : 0); }

bool same_place(const SweepReport& report, const SweepRow& a, const SweepRow& b) {
  return std::equal(a.typed.begin(), a.typed.begin() + std::ptrdiff_t(place_axes(report)), b.typed.begin());
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

std::string range_text(double low, double high, const std::string& name) {
  const Dimension dimension = dimension_of_name(name);
  return format_quantity(low, dimension) + " .. " + format_quantity(high, dimension);
}

std::size_t place_of(const SweepReport& report, const std::string& statistic) {
  return std::size_t(std::find(report.statistics.begin(), report.statistics.end(), statistic) -
                     report.statistics.begin());
}

std::vector<std::string> axis_labels(const SweepReport& report) {
  std::vector<std::string> pointers;
  for (const SweepAxis& axis : report.axes) pointers.push_back(axis.pointer);
  return short_labels(pointers);
}

// "rms 5 nm, B 1 m"; numbers without a unit of their own get that of the axis.
std::string place_text(const SweepReport& report, const std::vector<std::string>& labels,
                       const SweepRow& row) {
  std::string text;
  for (std::size_t k = 0; k < labels.size(); ++k) {
    const std::string& unit = report.axes[k].unit;
    const bool bare = !unit.empty() && row.typed[k].find_first_not_of("0123456789+-.eE") == std::string::npos;
    text += (k ? ", " : "") + labels[k] + " " + row.typed[k] + (bare ? " " + unit : "");
  }
  return text;
}

// The values that were typed, once each, in their order.
std::string typed_values(const SweepReport& report, std::size_t axis) {
  std::vector<std::string> seen;
  std::string text;
  for (const SweepRow& row : report.rows) {
    if (std::find(seen.begin(), seen.end(), row.typed[axis]) != seen.end()) continue;
    seen.push_back(row.typed[axis]);
    text += (text.empty() ? "" : ", ") + row.typed[axis];
  }
  return text;
}

// The cases in which each statistic is smallest and largest.
void add_extremes(Page* page, const SweepReport& report, const std::vector<std::string>& labels) {
  for (const std::string& name : report.shown) {
    const std::size_t at = place_of(report, name);
    const SweepRow *least = nullptr, *most = nullptr;
    for (const SweepRow& row : report.rows) {
      if (!std::isfinite(row.values[at])) continue;
      if (!least || row.values[at] < least->values[at]) least = &row;
      if (!most || row.values[at] > most->values[at]) most = &row;
    }
    if (!least) continue;
    const auto shown = [&](const SweepRow& row) {
      return format_quantity(row.values[at], dimension_of_name(name)) + " at " +
             place_text(report, labels, row);
    };
    page->answers.push_back(
        {name_without_unit(name), fmt::format("smallest {}; largest {}.", shown(*least), shown(*most))});
  }
}

// The computation of each case, in words.
std::string run_words(const std::string& run) {
  if (run == "check") return "theory without a fit (check)";
  if (run == "trace") return "the focus of one random surface (trace)";
  if (run == "fit") return "an equivalent surface and its verdict (fit)";
  return run == "solve" ? "the roughness that meets the budgets (solve)" : run;
}

SweepQuantiles over_all_rows(const SweepReport& report, std::size_t statistic) {
  std::vector<double> values;
  for (const SweepRow& row : report.rows) values.push_back(row.values[statistic]);
  return quantiles_of(std::move(values));
}

}  // namespace

std::size_t SweepReport::failed() const {
  return std::size_t(std::count_if(rows.begin(), rows.end(), [](const SweepRow& row) { return row.failed; }));
}

SweepQuantiles quantiles_of(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  std::sort(values.begin(), values.end());
  SweepQuantiles found;
  found.count = values.size();
  const auto at = [&](double p) {
    if (values.empty()) return kNaN;
    const double place = p * double(values.size() - 1), low = std::floor(place);
    const double below = values[std::size_t(low)];
    return place == low ? below : below + (place - low) * (values[std::size_t(low) + 1] - below);
  };
  double sum = 0, squares = 0;
  for (const double value : values) sum += value;
  found.mean = values.empty() ? kNaN : sum / double(values.size());
  for (const double value : values) squares += (value - found.mean) * (value - found.mean);
  found.standard_deviation = values.size() < 2 ? kNaN : std::sqrt(squares / double(values.size() - 1));
  found.smallest = at(0), found.q05 = at(0.05), found.q25 = at(0.25), found.q50 = at(0.5);
  found.q75 = at(0.75), found.q95 = at(0.95), found.largest = at(1);
  return found;
}

std::vector<SweepQuantiles> sweep_quantiles(const SweepReport& report, std::size_t statistic) {
  std::vector<SweepQuantiles> all;
  for (std::size_t begin = 0, end = 0; begin < report.rows.size(); begin = end) {
    std::vector<double> values;
    for (end = begin; end < report.rows.size() && same_place(report, report.rows[begin], report.rows[end]);
         ++end)
      values.push_back(report.rows[end].values[statistic]);
    all.push_back(quantiles_of(std::move(values)));
    all.back().row = begin;
  }
  return all;
}

std::string cases_csv(const SweepReport& report) {
  std::string text = "index,id";
  for (const SweepAxis& axis : report.axes) text += "," + csv_field(axis.pointer);
  text += ",status,verdict";
  for (const std::string& name : report.statistics) text += "," + csv_field(name);
  text += ",warnings,seconds,error\n";
  for (const SweepRow& row : report.rows) {
    fmt::format_to(std::back_inserter(text), "{},{}", row.index, row.id);
    for (const std::string& value : row.typed) text += "," + csv_field(value);
    text += std::string(",") + (row.failed ? "failed" : "done") + "," + row.verdict;
    for (const double value : row.values) text += "," + csv_value(value);
    fmt::format_to(std::back_inserter(text), ",{},{:.3g},{}\n", joined(row.warnings), row.seconds,
                   csv_field(row.error));
  }
  return text;
}

std::string quantiles_csv(const SweepReport& report) {
  std::string text;
  for (std::size_t k = 0; k < place_axes(report); ++k) text += csv_field(report.axes[k].pointer) + ",";
  text += "statistic,count,mean,standard_deviation,smallest,q05,q25,q50,q75,q95,largest\n";
  std::vector<std::vector<SweepQuantiles>> all;
  for (std::size_t s = 0; s < report.statistics.size(); ++s) all.push_back(sweep_quantiles(report, s));
  for (std::size_t place = 0; !all.empty() && place < all.front().size(); ++place)
    for (std::size_t s = 0; s < report.statistics.size(); ++s) {
      const SweepQuantiles& q = all[s][place];
      for (std::size_t k = 0; k < place_axes(report); ++k)
        text += csv_field(report.rows[q.row].typed[k]) + ",";
      fmt::format_to(std::back_inserter(text), "{},{}", csv_field(report.statistics[s]), q.count);
      for (const double value :
           {q.mean, q.standard_deviation, q.smallest, q.q05, q.q25, q.q50, q.q75, q.q95, q.largest})
        text += "," + csv_value(value);
      text += "\n";
    }
  return text;
}

Page page_of(const SweepReport& report) {
  const std::size_t failed = report.failed();
  Page page;
  page.title = report.title;
  page.headline = fmt::format("{}: {} of {} cases", report.is_complete() ? "SWEPT" : "NOT COMPLETE",
                              grouped(double(report.rows.size())), grouped(double(report.planned)));
  if (failed > 0) page.headline += fmt::format(", {} failed", grouped(double(failed)));
  page.tone = report.is_complete() && failed == 0 ? Page::Tone::kGood : Page::Tone::kOpen;
  const std::vector<std::string> labels = axis_labels(report);
  add_extremes(&page, report, labels);
  page.answers.push_back({"How certain", fmt::format("{} of {} cases have a result.",
                                                     report.rows.size() - failed, report.planned)});
  page.answers.push_back(
      {"What it rests on",
       "Each case is a study of its own with the values in cases.csv. Computed for each: " +
           run_words(report.run) + "."});
  page.answers.push_back(
      {"What would change it",
       "More realisations or finer steps in `vary` add cases; finished cases are not run again."});
  page.answers.push_back(
      {"What to do next",
       "Choose a case in cases.csv and put its values into the study; `aberfit fit` then finds the terms of "
       "that mirror."});
  Page::Table axes{"", {"what varies", "from .. to"}, "ll"};
  for (std::size_t k = 0; k < report.axes.size(); ++k) {
    std::vector<double> numbers;
    for (const SweepRow& row : report.rows) numbers.push_back(row.number[k]);
    const SweepQuantiles q = quantiles_of(std::move(numbers));
    axes.add({labels[k], report.axes[k].is_numeric && q.count > 0
                             ? fmt::format("{:.6g} .. {:.6g} {}", q.smallest, q.largest, report.axes[k].unit)
                             : typed_values(report, k)});
  }
  page.parts.push_back(std::move(axes));
  Page::Table table{"", {"statistic", "range", "median", "cases"}, "lrrr"};
  for (const std::string& name : report.shown) {
    const SweepQuantiles q = over_all_rows(report, place_of(report, name));
    table.add({name_without_unit(name), range_text(q.smallest, q.largest, name),
               format_quantity(q.q50, dimension_of_name(name)), std::to_string(q.count)});
  }
  page.parts.push_back(std::move(table));
  std::map<std::string, int> verdicts;
  for (const SweepRow& row : report.rows)
    if (!row.verdict.empty()) ++verdicts[row.verdict];
  for (const auto& [verdict, count] : verdicts) page.say("Verdict", fmt::format("{} {}", count, verdict));
  std::size_t told = 0;
  for (const SweepRow& row : report.rows) {
    if (!row.failed) continue;
    if (++told > kMostToldFailures) break;
    std::string at;
    for (std::size_t k = 0; k < labels.size(); ++k) at += (k ? ", " : "") + labels[k] + " " + row.typed[k];
    page.say("failed", at + ": " + row.error);
  }
  page.warnings = report.warnings;
  return page;
}

}  // namespace aberfit
