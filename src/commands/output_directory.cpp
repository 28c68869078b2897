#include "output_directory.h"

#include <filesystem>

#include "aberfit/study/read_study.h"

namespace aberfit::internal {

std::string default_output_directory(const std::string& study_file) {
  if (study_file == "-" || study_file == kStandardInput) return "out/study";
  const std::filesystem::path path = std::filesystem::absolute(study_file).lexically_normal();
  std::filesystem::path name = path.stem();
  if (path.filename() == "study.json" && path.parent_path().has_filename())
    name = path.parent_path().filename();
  return (std::filesystem::path("out") / name).string();
}

std::string default_chart_directory(const std::string& study_file) {
  return default_output_directory(study_file) + "-chart";
}

void choose_output_directory(CommandLine* line, const std::string& suffix) {
  if (line->output_directory.empty())
    line->output_directory = default_output_directory(line->study_file) + suffix;
}

}  // namespace aberfit::internal
