#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

// `--set /json/pointer=value`: a study changed on the command line.
namespace aberfit::internal {

/// Puts each of `changes`, "/json/pointer=value" as typed, into `json` in their order. The value is JSON, or
/// else a string; what the pointer leads through is made where it is missing, objects as a rule; an index of
/// an array may be that behind its last item. Throws InputError that names the option for text without
/// pointer or value and for a pointer that leads through a number, a word or beyond an array.
void apply_changes(const std::vector<std::string>& changes, nlohmann::ordered_json* json);

/// `file` as messages about `pointer` name it: with those of the changes that may be to blame, which are set
/// at that place, around it, inside it or beside it.
std::string file_with_changes(const std::string& file, const std::vector<std::string>& changes,
                              const std::string& pointer);

}  // namespace aberfit::internal
