#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "aberfit/commands/run_options.h"
#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/page.h"
#include "aberfit/report/result.h"
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// The provenance of a result: this program with its options, the study and the files that it names.
Provenance provenance_of(const Study& study, const RunOptions& options);

/// The provenance of a result of measured files; their paths start at the working folder.
Provenance provenance_of(const MeasuredPsd& measured, const RunOptions& options);

/// The parts of a result that every command writes.
struct WrittenResult {
  const Page& page;
  nlohmann::ordered_json document;  ///< result.json
  nlohmann::ordered_json asked;     ///< the study as typed
  std::vector<DrawnPicture> pictures = {};
  const Page* whole = nullptr;  ///< the page with its long tables, too; null: there are none
};
/// Writes summary.txt, result.json and report.html to `folder`.
void write_result(const std::string& folder, const RunOptions& options, const WrittenResult& result);

/// The study as it was typed, or the resolved study if a program has filled it.
nlohmann::ordered_json typed_study(const Study& study);

}  // namespace aberfit::internal
