#include "aberfit/chart/chart.h"

namespace aberfit {
namespace {

bool is_measured(const ChartRow& row) { return std::isfinite(row.error) && std::isfinite(row.seconds); }

bool dominates(const ChartRow& a, const ChartRow& b) {
  return a.error <= b.error && a.seconds <= b.seconds && (a.error < b.error || a.seconds < b.seconds);
}

}  // namespace

void mark_rows(ChartFamily* family) {
  ChartRow* cheapest = nullptr;
  for (ChartRow& row : family->rows) {
    row.on_frontier = is_measured(row);
    row.is_cheapest_within_tolerance = false;
    if (!is_measured(row)) continue;
    for (const ChartRow& other : family->rows)
      if (is_measured(other) && dominates(other, row)) row.on_frontier = false;
    if (row.error > family->tolerance || row.error_of_reference > family->tolerance) continue;
    if (!cheapest || row.seconds < cheapest->seconds ||
        (row.seconds == cheapest->seconds && row.error < cheapest->error))
      cheapest = &row;
  }
  if (cheapest) cheapest->is_cheapest_within_tolerance = true;
}

}  // namespace aberfit
