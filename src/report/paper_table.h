#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "aberfit/theory/paper_table.h"

namespace aberfit::internal {

/// `paper_table` of a check: one row per cell with both verdicts.
nlohmann::ordered_json to_json(const PaperCells& table);
std::string summary_table(const PaperCells& table);

}  // namespace aberfit::internal
