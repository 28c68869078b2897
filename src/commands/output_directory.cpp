#include "output_directory.h"

#include <unistd.h>

#include <filesystem>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/report/result.h"

namespace aberfit::internal {

std::string default_output_directory(const std::string& study_file) {
  const std::filesystem::path path = std::filesystem::absolute(study_file).lexically_normal();
  std::filesystem::path name = path.stem();
  if (path.filename() == "study.json" && path.parent_path().has_filename())
    name = path.parent_path().filename();
  return (std::filesystem::path("out") / name).string();
}

std::string default_chart_directory(const std::string& study_file) {
  return default_output_directory(study_file) + "-chart";
}

void choose_output_directory(CommandLine* line) {
  namespace fs = std::filesystem;
  if (line->output_directory.empty()) line->output_directory = default_output_directory(line->study_file);
  const fs::path folder = fs::absolute(line->output_directory).lexically_normal();
  std::vector<fs::path> absent;  // innermost first
  std::error_code error;
  for (fs::path p = folder; p.has_relative_path() && !fs::exists(p, error); p = p.parent_path())
    absent.push_back(p);
  const auto remove_absent = [&absent] {
    std::error_code ignored;
    for (const fs::path& p : absent) fs::remove(p, ignored);  // only where empty
  };
  try {
    const fs::path probe = folder / (".aberfit-" + std::to_string(getpid()));
    write_file(probe.string(), "");
    fs::remove(probe, error);
    remove_absent();
  } catch (const InputError& failure) {
    remove_absent();
    throw InputError(line->output_directory, "", failure.found(), "a folder to write to");
  }
}

}  // namespace aberfit::internal
