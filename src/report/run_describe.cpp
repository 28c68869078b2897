// Facts about runs of many: kinds "sweep", "chart" and "verify".
#include <algorithm>
#include <cmath>

#include "facts.h"

namespace aberfit::internal {

static void describe(Facts& facts, const SweepAxis& axis) {
  facts("pointer", axis.pointer, "JSON pointer to the number in the study.");
  facts("unit", axis.unit.empty() ? std::nullopt : std::optional(axis.unit), "Unit of the values.");
  facts("numeric", axis.is_numeric, "Whether all values are numbers.");
}

static void describe(Facts& facts, const SweepQuantiles& q) {
  facts("count", q.count, "Number of cases that have a value.");
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
  facts("id", failed.row.id, "Name of the case in the journal.");
  facts("at", at, "Values of the case as written in the study, by pointer.");
  facts("error", failed.row.error, "Error message.");
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
    cases("planned", report.planned, "Number of planned cases.");
    cases("recorded", report.rows.size(), "Number of cases in this result.");
    cases("done", report.rows.size() - report.failed(), "Number of cases that have a result.");
    cases("failed", report.failed(), "Number of cases that failed.");
  });
  facts.keyed("statistics", report.statistics, over_all, "Distribution of each statistic over all cases.");
  facts("verdicts", verdicts.empty() ? std::nullopt : std::optional(verdicts),
        "Number of cases with each verdict; null where nothing is judged.");
  facts("failures", failures, "The cases that failed.");
  facts("seconds", seconds, "Time of all cases together.");
  facts("warnings", report.warnings, "Warnings that the reader should know.");
}

static void describe(Facts& facts, const ChartFamily& family) {
  facts("name", family.name, "Name of the family; its rows compute the same thing.");
  facts("title", family.title, "Its title.");
  facts("error_of", family.error_of, "Quantity whose error is given.");
  facts("timed", family.timed, "Work that is timed.");
  facts("tolerance", family.tolerance, "Tolerance of the error.");
  facts("tolerance_of", family.tolerance_of, "Origin of the tolerance.");
  facts("rows", family.rows.size(), "Number of its rows.");
  facts("remark", family.remark, "Remark that the rows do not contain.");
  facts("skipped", family.skipped.empty() ? std::nullopt : std::optional(family.skipped),
        "Reason why there are no rows.");
}

static void describe(Facts& facts, const ChartRow& row) {
  facts("family", row.family, "Its family.");
  facts("method", row.method, "The method.");
  facts("parameter", row.parameter, "What is varied.");
  facts("value", row.value, "Its value.");
  facts("unit", row.unit, "Its unit.");
  facts("rays", row.rays, "Number of rays or grid points.");
  facts("terms", row.terms, "Number of terms.");
  facts("statistics", row.statistics, "Number of statistics.");
  facts("error", row.error, "Error of the quantity that the family names.");
  facts("error_rms", row.error_rms, "Root mean square of the differences; the error is their largest.");
  facts("error_of_reference", row.error_of_reference, "Error of the reference itself.");
  facts("reference", row.reference, "Reference of the comparison.");
  facts("seconds", row.seconds, "Median time.");
  facts("seconds_low", row.seconds_low, "Lower quartile of the time.");
  facts("seconds_high", row.seconds_high, "Upper quartile of the time.");
  facts("repeats", row.repeats, "Number of timed repetitions.");
  facts("on_frontier", row.on_frontier, "Whether no other row is better in both error and time.");
  facts("is_default", row.is_default, "Whether the study uses this setting.");
  facts("is_cheapest_within_tolerance", row.is_cheapest_within_tolerance,
        "Whether this row is the fastest within the tolerance.");
  facts("note", row.note, "Further observation.");
}

void describe(Facts& facts, const Chart& chart) {
  std::vector<ChartRow> rows;
  for (const ChartFamily& family : chart.families)
    rows.insert(rows.end(), family.rows.begin(), family.rows.end());
  facts.object("machine", "Machine that the times were measured on.", [&](Facts& machine) {
    machine("threads", chart.threads, "Number of threads.");
    machine("instruction_set", chart.instruction_set, "Instruction set of the kernels.");
  });
  facts("families", chart.families, "Groups of rows that compute the same thing.");
  facts("rows", rows, "Measurements; each row is one method with one setting.");
  facts("budget_seconds", chart.budget_seconds, "Requested time.");
  facts("seconds", chart.seconds, "Time that was used.");
  facts("warnings", chart.warnings, "Warnings that the reader should know.");
}

}  // namespace aberfit::internal
