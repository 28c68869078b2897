// Facts about runs of many: kinds "sweep", "chart" and "verify".
#include <algorithm>
#include <cmath>

#include "facts.h"

namespace aberfit::internal {

static void describe(Facts& facts, const SweepAxis& axis) {
  facts("pointer", axis.pointer, "Where the number stands in the study.");
  facts("unit", axis.unit.empty() ? std::nullopt : std::optional(axis.unit), "Unit of its values.");
  facts("numeric", axis.is_numeric, "Whether all of its values are numbers.");
}

static void describe(Facts& facts, const SweepQuantiles& q) {
  facts("count", q.count, "Cases that have a value.");
  facts("mean", q.mean, "Mean over all cases.");
  facts("smallest", q.smallest, "Smallest value.");
  facts("median", q.q50, "Median.");
  facts("largest", q.largest, "Largest value.");
}

namespace {

struct FailedCase {
  SweepRow row;
  std::vector<std::string> pointers;
};

void describe(Facts& facts, const FailedCase& failed) {
  std::map<std::string, std::string> at;
  for (std::size_t k = 0; k < failed.pointers.size(); ++k) at[failed.pointers[k]] = failed.row.typed[k];
  facts("index", failed.row.index, "Number of the case.");
  facts("id", failed.row.id, "Its name in the journal.");
  facts("at", at, "Its values as typed, by pointer.");
  facts("error", failed.row.error, "What went wrong.");
}

}  // namespace

void describe(Facts& facts, const SweepReport& report) {
  std::vector<SweepQuantiles> over_all;
  for (std::size_t s = 0; s < report.statistics.size(); ++s) {
    std::vector<double> values;
    for (const SweepRow& row : report.rows) values.push_back(row.values[s]);
    over_all.push_back(quantiles_of(std::move(values)));
  }
  std::vector<std::string> pointers;
  for (const SweepAxis& axis : report.axes) pointers.push_back(axis.pointer);
  std::map<std::string, int> verdicts;
  std::vector<FailedCase> failures;
  double seconds = 0;
  for (const SweepRow& row : report.rows) {
    seconds += row.seconds;
    if (!row.verdict.empty()) ++verdicts[row.verdict];
    if (row.failed) failures.push_back({row, pointers});
  }
  facts("run", report.run, "What was computed of each case.");
  facts("axes", report.axes, "What varies.");
  facts.object("cases", "How many cases there are.", [&](Facts& cases) {
    cases("planned", report.planned, "In the plan.");
    cases("recorded", report.rows.size(), "In this result.");
    cases("done", report.rows.size() - report.failed(), "That have a result.");
    cases("failed", report.failed(), "That have none.");
  });
  facts.keyed("statistics", report.statistics, over_all, "Each statistic over all cases.");
  facts("verdicts", verdicts.empty() ? std::nullopt : std::optional(verdicts),
        "How many cases have which verdict; null where nothing is judged.");
  facts("failures", failures, "The cases that failed.");
  facts("seconds", seconds, "Time of all cases together.");
  facts("warnings", report.warnings, "What a reader has to know.");
}

static void describe(Facts& facts, const ChartFamily& family) {
  facts("name", family.name, "Name of the family, whose rows do the same job.");
  facts("title", family.title, "Its title.");
  facts("error_of", family.error_of, "What the error is.");
  facts("timed", family.timed, "What the time is of.");
  facts("tolerance", family.tolerance, "What the error is held against.");
  facts("tolerance_of", family.tolerance_of, "Where that comes from.");
  facts("rows", family.rows.size(), "Number of its rows.");
  facts("remark", family.remark, "What the rows do not say.");
  facts("skipped", family.skipped.empty() ? std::nullopt : std::optional(family.skipped),
        "Why there are no rows.");
}

static void describe(Facts& facts, const ChartRow& row) {
  facts("family", row.family, "Its family.");
  facts("method", row.method, "The method.");
  facts("parameter", row.parameter, "What is varied.");
  facts("value", row.value, "Its value.");
  facts("unit", row.unit, "Its unit.");
  facts("rays", row.rays, "Number of rays or grid cells.");
  facts("terms", row.terms, "Number of terms.");
  facts("statistics", row.statistics, "Number of statistics.");
  facts("error", row.error, "The error, as the family says.");
  facts("error_rms", row.error_rms, "Root mean square of what the error is the largest of.");
  facts("error_of_reference", row.error_of_reference, "Error of the reference itself.");
  facts("reference", row.reference, "What it was compared with.");
  facts("seconds", row.seconds, "Median time.");
  facts("seconds_low", row.seconds_low, "Lower quartile of the time.");
  facts("seconds_high", row.seconds_high, "Upper quartile of the time.");
  facts("repeats", row.repeats, "How often it was timed.");
  facts("on_frontier", row.on_frontier, "Whether no other row is better in both.");
  facts("is_default", row.is_default, "Whether the study does this today.");
  facts("is_cheapest_within_tolerance", row.is_cheapest_within_tolerance,
        "Whether it is the fastest within the tolerance.");
  facts("note", row.note, "What else was seen.");
}

void describe(Facts& facts, const Chart& chart) {
  std::vector<ChartRow> rows;
  for (const ChartFamily& family : chart.families)
    rows.insert(rows.end(), family.rows.begin(), family.rows.end());
  facts.object("machine", "What the times were measured on.", [&](Facts& machine) {
    machine("threads", chart.threads, "Number of threads.");
    machine("instruction_set", chart.instruction_set, "Instruction set of the kernels.");
  });
  facts("families", chart.families, "Groups of rows that do the same job.");
  facts("rows", rows, "One method with one setting each.");
  facts("budget_seconds", chart.budget_seconds, "Time that was asked for.");
  facts("seconds", chart.seconds, "Time that it took.");
  facts("warnings", chart.warnings, "What a reader has to know.");
}

}  // namespace aberfit::internal
