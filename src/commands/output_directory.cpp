#include "output_directory.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "aberfit/commands/run.h"
#include "aberfit/study/read_study.h"

namespace aberfit::internal {

std::string default_output_directory(const std::string& study_file, const std::string& command) {
  std::filesystem::path name = "study";
  if (study_file != "-" && study_file != kStandardInput) {
    const std::filesystem::path path = std::filesystem::absolute(study_file).lexically_normal();
    name = path.stem();
    if ((path.filename() == "study.json" || path.filename() == "study.jsonc") &&
        path.parent_path().has_filename())
      name = path.parent_path().filename();
  }
  return (std::filesystem::path("out") / name / command).string();
}

void choose_output_directory(CommandLine* line, const std::string& command) {
  if (line->output_directory.empty())
    line->output_directory = default_output_directory(line->study_file, command);
}

ResultClaim claim_of(const std::string& command, const RunOptions& options, std::vector<std::string> files,
                     const PictureOptions& pictures, const std::vector<std::string>& names) {
  for (const char* file : {"summary.txt", "result.json", "report.html"}) files.emplace_back(file);
  ResultClaim claim{command, std::move(files), options.force, options.tell};
  if (pictures.format == PictureFormat::kNone) return claim;
  claim.names.emplace_back("plots/common.gp");
  for (const std::string& name : names) claim.names.push_back("plots/" + name + "*");
  return claim;
}

PictureOptions wanted_pictures(const RunOptions& options, const Study* study) {
  const PictureFormat of_study = study ? study->output.pictures : PictureFormat::kAuto;
  return {options.pictures.value_or(of_study), context_of(options).threads};
}

PictureFormat picture_format(const std::string& word) {
  const std::vector<std::string>& names = picture_format_names();
  return PictureFormat(std::find(names.begin(), names.end(), word) - names.begin());
}

}  // namespace aberfit::internal
