#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "aberfit/study/study.h"

namespace aberfit::internal {

/// The text of a study; "-" is standard input. Throws InputError if the file cannot be read.
std::string text_of_study(const std::string& path);

/// The study that `json` describes, with the contents of its files. changes: those made to it, for messages.
/// same_roughness: a study with the same roughness, already measured, or null. data: as for parse_study.
Study study_of_json(const nlohmann::ordered_json& json, const std::string& path,
                    const std::vector<std::string>& changes, const Study* same_roughness,
                    const StudyData& data = {});

}  // namespace aberfit::internal
