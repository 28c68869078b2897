// `aberfit report` shows several results side by side.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "aberfit/commands/program.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/report/html_report.h"
#include "aberfit/report/result.h"

namespace aberfit {

namespace {

namespace fs = std::filesystem;

nlohmann::ordered_json result_in(const std::string& folder) {
  const fs::path file = fs::path(folder) / "result.json";
  const auto bytes = file_bytes(file.string());
  const auto document = nlohmann::ordered_json::parse(bytes.value_or(""), nullptr, false);
  if (!document.is_object() || !document.contains("kind") || !document.contains("aberfit"))
    throw InputError(file.string(), "",
                     bytes ? "a file that is not a result of aberfit" : "a file that cannot be read",
                     "a folder with the results of a command");
  return document;
}

// The link is relative to the page, and empty if there is no report.
std::string link_to(const std::string& folder, const fs::path& page) {
  const fs::path report = fs::path(folder) / "report.html";
  if (!fs::exists(report)) return "";
  return fs::absolute(report).lexically_proximate(fs::absolute(page).parent_path()).generic_string();
}

}  // namespace

ExitCode report_command(CommandLine line) {
  if (line.output_directory.empty()) line.output_directory = "comparison.html";
  const fs::path page = line.output_directory;
  std::error_code none;
  if (fs::exists(page, none) && !line.force)
    throw InputError(page.string(), "", "a file or folder of that name",
                     "another name with --output, or --force to replace a file");
  std::vector<nlohmann::ordered_json> documents;
  for (const std::string& folder : line.result_folders) documents.push_back(result_in(folder));
  std::vector<ComparedResult> results;
  for (std::size_t k = 0; k < documents.size(); ++k)
    results.push_back({line.result_folders[k], documents[k], link_to(line.result_folders[k], page)});
  const std::vector<Page::Text> run = {
      {"page made", fmt::format("{:%Y-%m-%d %H:%M:%S} UTC by aberfit {}", fmt::gmtime(std::time(nullptr)),
                                make_provenance(0, 1).version)},
      {"machine", this_machine()}};
  write_file(page.string(), html_of(results, run));
  if (!line.quiet) fmt::print(stderr, "report in {}\n", page.string());
  return ExitCode::kDone;
}

}  // namespace aberfit
