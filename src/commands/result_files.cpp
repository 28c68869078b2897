#include "result_files.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <filesystem>

#include "aberfit/commands/run.h"
#include "aberfit/core/content_hash.h"
#include "aberfit/core/text.h"
#include "aberfit/fit/calibrate.h"
#include "aberfit/report/html_report.h"
#include "aberfit/study/read_study.h"

namespace aberfit::internal {
namespace {

// Collects the files that a study names, in the order of their keys.
void collect_files(const nlohmann::ordered_json& node, std::vector<std::string>* files) {
  for (const auto& [key, value] : node.items())
    if (value.is_structured())
      collect_files(value, files);
    else if (names_file(key) && value.is_string())
      files->push_back(value.get<std::string>());
}

// The files are relative to `folder`; unreadable ones are left out.
Provenance provenance_of_files(std::uint64_t seed, const RunOptions& options,
                               const std::vector<std::string>& files, const std::filesystem::path& folder) {
  Provenance provenance = make_provenance(seed, context_of(options).threads);
  provenance.libraries["ceres"] = solver_version();
  for (const std::string& file : files)
    if (const auto bytes = file_bytes((folder / file).string()))
      provenance.inputs.push_back({file, content_hash(*bytes)});
  return provenance;
}

}  // namespace

nlohmann::ordered_json typed_study(const Study& study) {
  return study.typed.empty() ? resolved_study(study) : nlohmann::ordered_json::parse(study.typed);
}

Provenance provenance_of(const Study& study, const RunOptions& options) {
  std::vector<std::string> files;
  collect_files(typed_study(study), &files);
  Provenance provenance = provenance_of_files(study.map ? study.map->fit.seed : study.fit.seed, options,
                                              files, std::filesystem::path(study.path).parent_path());
  if (const auto bytes = file_bytes(study.path))
    provenance.inputs.insert(provenance.inputs.begin(), {study.path, content_hash(*bytes)});
  return provenance;
}

Provenance provenance_of(const MeasuredPsd& measured, const RunOptions& options) {
  std::vector<std::string> files = {measured.source.file};
  for (const MeasuredFile& file : measured.further) files.push_back(file.file);
  return provenance_of_files(0, options, files, "");
}

void write_result(const std::string& folder, const RunOptions& options, const WrittenResult& result) {
  const Page& whole = result.whole ? *result.whole : result.page;
  write_file(folder + "/summary.txt", text_of(whole));
  write_file(folder + "/result.json", result.document.dump(2) + "\n");
  const std::vector<Page::Text> run = {
      {"date", fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(std::time(nullptr)))},
      {"command", options.command_line.empty() ? "a call of the library" : options.command_line},
      {"machine", this_machine()}};
  write_file(folder + "/report.html", html_of({result.page, result.document, result.asked, result.pictures,
                                               folder, run, result.whole}));
}

}  // namespace aberfit::internal
