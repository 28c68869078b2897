#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/study/study_cases.h"

namespace aberfit {

/// What came of a case.
struct CaseOutcome {
  std::vector<std::pair<std::string, double>> values;  ///< by name with its SI unit; NaN: does not exist
  std::string verdict;                                 ///< of a fit or a solve; else empty
  std::vector<std::string> warnings;                   ///< codes
};

/// A line of the records: a case that was done, or that failed.
struct CaseRecord : CaseOutcome {
  std::string id;         ///< StudyCases::id
  std::string base;       ///< StudyCases::base
  std::size_t index = 0;  ///< in the plan that it was computed for
  CaseValues at;
  std::string error;  ///< why it failed; empty: it did not
  double seconds = 0;
};

/// One line of JSON with the line end (FORMATS, `cases/*.jsonl`).
std::string to_line(const CaseRecord& record);
/// Nothing for a line that is no record.
std::optional<CaseRecord> record_of(const std::string& line);

}  // namespace aberfit
