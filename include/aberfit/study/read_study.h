#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "aberfit/study/study.h"

namespace aberfit {

/// Reads and checks a study file (format version 1), loading the tables it names (paths relative to the study file).
/// Throws InputError with file, JSON pointer, what was found and what is allowed: unknown keys (with the nearest known one), duplicate keys,
/// wrong types, missing or wrong units, values out of range, unreadable files.
Study read_study(const std::string& path);
/// The same from text; `path` names the file in messages and anchors relative paths.
Study parse_study(const std::string& text, const std::string& path);

/// The study with every default filled in: itself a valid study with the same meaning.
nlohmann::ordered_json resolved_study(const Study& study);

/// JSON Schema (draft 2020-12) of the study format, made from the same description that reads it.
nlohmann::ordered_json study_schema();

}  // namespace aberfit
