#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "aberfit/method/character.h"
#include "aberfit/method/tost.h"

namespace aberfit {

/// `character` of result.json.
nlohmann::ordered_json to_json(const Character& character);
/// What the verdict's line says beside `verdict`: "PSD and shape those of draws", "but not of this roughness:
/// PSD 3.1 times at 12 /m".
std::string character_words(const Character& character, Verdict verdict);
/// What the summary says: every property beside its draws, and the same surface in other light.
std::string character_table(const Character& character);

}  // namespace aberfit
