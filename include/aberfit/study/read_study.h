#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "aberfit/method/plan.h"
#include "aberfit/study/study.h"

namespace aberfit {

/// Reads and checks a study file (format version 1), loading the tables it names (paths relative to the study
/// file). Throws InputError with file, JSON pointer, what was found and what is allowed: unknown keys (with
/// the nearest known one), duplicate keys, wrong types, missing or wrong units, values out of range,
/// unreadable files. path "-": standard input, with paths relative to the working folder. changes: set in the
/// study before it is read, each "/json/pointer=value" as for `--set`. A value is JSON if it parses,
/// otherwise a string. Messages about a changed value name its change.
/// data: stand in for the files of target.map, of the first measurement of the roughness (a profile, or the
/// map unless target.map has it) and of a mask. Throws InputError for data without such a place.
Study read_study(const std::string& path, const std::vector<std::string>& changes = {},
                 const StudyData& data = {});
/// The same from text; `path` names the file in messages and anchors relative paths.
Study parse_study(const std::string& text, const std::string& path,
                  const std::vector<std::string>& changes = {}, const StudyData& data = {});

/// Study::path of a study read from standard input.
inline constexpr const char* kStandardInput = "standard input";

/// Measurement -> PSD -> model from a `psd` block of model "measured" (without the key "model"), as `aberfit
/// psd FILE` does it. Paths are relative to the working directory; errors name the block `source`.
MeasuredPsd read_measured(const nlohmann::ordered_json& block, const std::string& source, int threads);

/// A `psd` block as JSON, SI numbers.
nlohmann::ordered_json psd_block(const RoughnessModel& roughness);
/// The node that stands for a model in a study.
RoughnessModel roughness_model(const PsdModel& model);

/// The study with every default filled in: itself a valid study with the same meaning.
nlohmann::ordered_json resolved_study(const Study& study);
/// The same, with the terms and rays that a fit chose where the study leaves the choice to it.
nlohmann::ordered_json resolved_study(const Study& study, const ChosenByFit& chosen);

/// Returns whether a key of a study names a data file, wherever the key stands.
bool names_file(const std::string& key);

/// JSON Schema (draft 2020-12) of the study format, made from the same description that reads it.
nlohmann::ordered_json study_schema();

}  // namespace aberfit
