#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/study/study_cases.h"

namespace aberfit {

struct CaseOutcome {
  std::vector<std::pair<std::string, double>> values;  ///< by name with its SI unit; NaN: does not exist
  std::string verdict;                                 ///< verdict of a fit or a solve; else empty
  std::vector<std::string> warnings;                   ///< codes
};

/// One line of the records: a case with a result, or with an error.
struct CaseRecord : CaseOutcome {
  std::string id;         ///< StudyCases::id
  std::string base;       ///< StudyCases::base
  std::size_t index = 0;  ///< in the plan for which it was computed
  CaseValues at;
  std::string error;  ///< why it failed; empty if it did not
  double seconds = 0;
};

/// One line of JSON with the line end (FORMATS, `cases/*.jsonl`).
std::string to_line(const CaseRecord& record);
/// Empty for a line that is no record.
std::optional<CaseRecord> record_of(const std::string& line);

}  // namespace aberfit
