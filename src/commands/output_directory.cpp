#include "output_directory.h"

#include <filesystem>
#include <utility>

#include "aberfit/study/read_study.h"

namespace aberfit::internal {

std::string default_output_directory(const std::string& study_file, const std::string& command) {
  std::filesystem::path name = "study";
  if (study_file != "-" && study_file != kStandardInput) {
    const std::filesystem::path path = std::filesystem::absolute(study_file).lexically_normal();
    name = path.stem();
    if (path.filename() == "study.json" && path.parent_path().has_filename())
      name = path.parent_path().filename();
  }
  return (std::filesystem::path("out") / name / command).string();
}

void choose_output_directory(CommandLine* line, const std::string& command) {
  if (line->output_directory.empty())
    line->output_directory = default_output_directory(line->study_file, command);
}

ResultClaim claim_of(const std::string& command, const RunOptions& options, std::vector<std::string> files,
                     bool plots, const std::vector<std::string>& pictures) {
  ResultClaim claim{command, std::move(files), options.force, options.tell};
  if (plots)
    for (const std::string& picture : pictures) claim.names.push_back("plots/" + picture + "*");
  return claim;
}

}  // namespace aberfit::internal
