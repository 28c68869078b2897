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

/// What makes a result: this program with these options, the study and the files that it names.
Provenance provenance_of(const Study& study, const RunOptions& options);

/// The same of measured files; their paths start at the working folder.
Provenance provenance_of(const MeasuredPsd& measured, const RunOptions& options);

/// What every command writes of its result.
struct WrittenResult {
  const Page& page;
  nlohmann::ordered_json document;  ///< result.json
  nlohmann::ordered_json asked;     ///< the study as typed
  std::vector<DrawnPicture> pictures = {};
  const Page* whole =
      nullptr;  ///< the page with tables that are too long to begin with; null: there are none
};
/// Writes summary.txt, result.json and report.html to `folder`.
void write_result(const std::string& folder, const RunOptions& options, const WrittenResult& result);

/// The study as it was typed; of one that a program has filled, the resolved one.
nlohmann::ordered_json typed_study(const Study& study);

}  // namespace aberfit::internal
