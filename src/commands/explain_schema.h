#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace aberfit::internal {

/// Explains one key of the study in lines of `width` characters: its meaning, type, units, range, default and
/// example, and a table of the keys below it.
/// key: names joined by slashes, "roughness/psd/rms", or only the last name if it is unique. If several keys
/// have this name, they are listed with their meanings. A word that decides which keys there are ("annulus")
/// lists them; "study" stands for the whole study. Throws InputError with the nearest keys if the schema does
/// not have the key.
std::string explained_key(const nlohmann::ordered_json& schema, const std::string& key, int width);

}  // namespace aberfit::internal
