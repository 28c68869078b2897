#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

// `--set /json/pointer=value`: a study changed on the command line.
namespace aberfit::internal {

/// Sets each of `changes`, "/json/pointer=value" as typed, in `json`, in their order. A value that is not
/// JSON is a string. Missing values on the pointer's way are created, usually as objects. An array index may
/// be one past the last item. Throws an InputError that names the option for text without pointer or value,
/// and for a pointer that leads through a number or a word or beyond an array.
void apply_changes(const std::vector<std::string>& changes, nlohmann::ordered_json* json);

/// The name of `file` for messages about `pointer`, with the changes that may be to blame: those at that
/// place, around it, inside it or beside it.
std::string file_with_changes(const std::string& file, const std::vector<std::string>& changes,
                              const std::string& pointer);

}  // namespace aberfit::internal
