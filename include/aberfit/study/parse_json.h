#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace aberfit {

/// Parses `text` as JSON and keeps the order of its keys. Throws InputError for a syntax error (with line and
/// column), for a key that occurs twice in one object (with its JSON pointer), for numbers beyond double and
/// for nesting deeper than 64 levels. `path` names the file. If it ends in .jsonc, comments (// and /* */)
/// may stand between tokens; otherwise they are a syntax error.
nlohmann::ordered_json parse_json(const std::string& text, const std::string& path);

/// `pointer` + "/" + key with ~ and / escaped (RFC 6901).
std::string child_pointer(const std::string& pointer, const std::string& key);

}  // namespace aberfit
