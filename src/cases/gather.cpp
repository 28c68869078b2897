#include "aberfit/cases/gather.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <unordered_map>

#include "aberfit/core/errors.h"
#include "aberfit/study/unusual.h"

namespace aberfit {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostShown = 6;

// Base and values identify a case. If a file varies or an earlier study had the case, we must read it.
const CaseRecord* record_at(const StudyCases& cases, const CasePlan& plan, const KnownCases& known,
                            std::size_t index) {
  const CaseValues at = plan.at(index);
  if (const CaseRecord* record = known.find(cases.base(), at)) return record;
  if (known.empty()) return nullptr;
  try {
    return known.find_id(cases.id(cases.at(at)));
  } catch (const InputError&) {
    return known.find_id(cases.id_of_unreadable(at));
  }
}

// Values of one axis as numbers, in the unit of the first.
void read_axis(const StudyCases& cases, const CasePlan& plan, std::size_t k, SweepAxis* axis) {
  std::vector<std::string> values = k < plan.axes() ? plan.values(k) : std::vector<std::string>{};
  if (values.empty()) values = {plan.at(0)[k].second};
  axis->pointer = plan.pointers()[k];
  axis->is_numeric = true;
  for (std::size_t i = 0; i < values.size(); ++i) {
    NumberWithUnit number;
    const bool is_number = read_number(values[i], &number);
    if (i == 0) axis->unit = number.unit;
    axis->is_numeric = axis->is_numeric && is_number && number.unit == axis->unit;
  }
  if (!axis->is_numeric) axis->unit = "";
  if (k >= plan.axes()) return;
  const VaryAxis& asked = cases.study().vary->axes[k];
  axis->is_log = asked.spacing == "log";
}

SweepRow row_of(const CaseRecord& record, std::size_t index, const CaseValues& at,
                const std::vector<SweepAxis>& axes) {
  SweepRow row;
  row.index = index;
  row.id = record.id;
  for (std::size_t k = 0; k < at.size(); ++k) {
    const Json value = Json::parse(at[k].second);
    NumberWithUnit number{std::nan(""), ""};
    if (axes[k].is_numeric) read_number(at[k].second, &number);
    row.typed.push_back(value.is_string() ? value.get<std::string>() : at[k].second);
    row.number.push_back(number.number);
  }
  row.failed = !record.error.empty();
  row.error = record.error;
  row.verdict = record.verdict;
  row.warnings = record.warnings;
  row.seconds = record.seconds;
  return row;
}

// The statistics to show first: results, not the numbers of the scene.
std::vector<std::string> shown_of(const std::vector<std::string>& statistics) {
  std::vector<std::string> shown;
  const auto is_number_of_scene = [](const std::string& name) {
    return name.starts_with("scene_") || name.starts_with("target_") || name == "terms";
  };
  for (const std::string& name : statistics)
    if (!is_number_of_scene(name) && shown.size() < kMostShown) shown.push_back(name);
  return shown;
}

// Reports what is unusual in the first such case, once for all cases. The study itself may not be a case.
void note_unusual_cases(const StudyCases& cases, const CasePlan& plan, SweepReport* report) {
  const auto is_unusual = [](const SweepRow& row) {
    return std::find(row.warnings.begin(), row.warnings.end(), kUnusual) != row.warnings.end();
  };
  const auto first = std::find_if(report->rows.begin(), report->rows.end(), is_unusual);
  if (first == report->rows.end()) return;
  const auto count = std::count_if(report->rows.begin(), report->rows.end(), is_unusual);
  for (const Warning& warning : unusual_warnings(cases.at(plan.at(first->index))))
    report->warnings.push_back(
        {kUnusual, fmt::format("{} of {} cases have an unusual number. Case {}: {}", count,
                               report->rows.size(), first->index, warning.message)});
}

}  // namespace

SweepReport gather_cases(const StudyCases& cases, const CasePlan& plan, const KnownCases& known) {
  const VarySpec& vary = *cases.study().vary;
  SweepReport report;
  report.title = cases.study().title;
  report.run = to_string(vary.run);
  report.is_grid = vary.design == VaryDesign::kGrid;
  report.has_seeds = plan.realisations() > 1;
  report.planned = plan.size();
  for (std::size_t k = 0; k < plan.pointers().size(); ++k) {
    report.axes.emplace_back();
    read_axis(cases, plan, k, &report.axes.back());
  }
  std::unordered_map<std::string, std::size_t> place_of;
  for (std::size_t index = 0; index < plan.size(); ++index) {
    const CaseRecord* record = record_at(cases, plan, known, index);
    if (!record) continue;
    report.rows.push_back(row_of(*record, index, plan.at(index), report.axes));
    std::vector<double>& values = report.rows.back().values;
    for (const auto& [name, value] : record->values) {
      const auto [at, is_new] = place_of.emplace(name, report.statistics.size());
      if (is_new) report.statistics.push_back(name);
      values.resize(report.statistics.size(), std::nan(""));
      values[at->second] = value;
    }
  }
  for (SweepRow& row : report.rows) row.values.resize(report.statistics.size(), std::nan(""));
  report.shown = shown_of(report.statistics);
  note_unusual_cases(cases, plan, &report);
  return report;
}

std::vector<std::size_t> cases_left(const StudyCases& cases, const CasePlan& plan, const KnownCases& known,
                                    const Shard& shard) {
  std::vector<std::size_t> left;
  for (std::size_t index = 0; index < plan.size(); ++index)
    if (shard.holds(index) && !known.find(cases.base(), plan.at(index))) left.push_back(index);
  return left;
}

}  // namespace aberfit
