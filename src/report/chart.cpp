#include "aberfit/report/chart.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "aberfit/core/units.h"
#include "csv_field.h"

namespace aberfit {
using namespace internal;

namespace {

std::string csv_number(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : ""; }

}  // namespace

std::string chart_csv(const Chart& chart) {
  std::string text =
      "family,method,parameter,value,unit,rays,terms,statistics,error,error_rms,error_of_reference,tolerance,"
      "reference,seconds,seconds_low,seconds_high,repeats,on_frontier,is_default,is_cheapest_within_"
      "tolerance,error_of,timed,note\n";
  for (const ChartFamily& family : chart.families)
    for (const ChartRow& row : family.rows)
      fmt::format_to(std::back_inserter(text),
                     "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{:d},{:d},{:d},{},{},{}\n",
                     csv_field(row.family), csv_field(row.method), csv_field(row.parameter),
                     csv_number(row.value), csv_field(row.unit), row.rays, row.terms, row.statistics,
                     csv_number(row.error), csv_number(row.error_rms), csv_number(row.error_of_reference),
                     csv_number(family.tolerance), csv_field(row.reference), csv_number(row.seconds),
                     csv_number(row.seconds_low), csv_number(row.seconds_high), row.repeats, row.on_frontier,
                     row.is_default, row.is_cheapest_within_tolerance, csv_field(family.error_of),
                     csv_field(family.timed), csv_field(row.note));
  return text;
}

}  // namespace aberfit
