#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace aberfit::internal {

/// One key of the study in words: its meaning, type, units, range, default and example, and the keys below it
/// as a table, in lines of `width` characters.
/// key: names joined by slashes, "roughness/psd/rms", or the last of them alone where that is unique; several
/// keys of one name are listed with their meanings; a word that decides which keys there are, "annulus", has
/// these; "study" stands for the whole. Throws InputError with the
/// nearest keys for one that the schema does not have.
std::string explained_key(const nlohmann::ordered_json& schema, const std::string& key, int width);

}  // namespace aberfit::internal
