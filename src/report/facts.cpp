#include "facts.h"

#include <array>
#include <string_view>

namespace aberfit::internal {

std::string unit_of_key(const std::string& key) {
  struct Suffix {
    std::string_view end, unit;
  };
  // Longer endings come first, because _per_m2 is no area.
  static constexpr std::array kSuffixes = {Suffix{"_per_m2", "1/m^2"}, Suffix{"_rad_per_m", "rad/m"},
                                           Suffix{"_per_m", "1/m"},    Suffix{"_per_sr", "1/sr"},
                                           Suffix{"_m2", "m^2"},       Suffix{"_m3", "m^3"},
                                           Suffix{"_m4", "m^4"},       Suffix{"_m", "m"},
                                           Suffix{"_rad", "rad"},      Suffix{"seconds", "s"},
                                           Suffix{"bytes", "byte"}};
  for (const Suffix& suffix : kSuffixes)
    if (key.ends_with(suffix.end)) return std::string(suffix.unit);
  return "";
}

void Facts::put_schema(const char* key, Json schema, const char* meaning, bool always) {
  schema["description"] = meaning;
  if (const std::string unit = unit_of_key(key); !unit.empty()) schema["unit"] = unit;
  members_[key] = std::move(schema);
  if (always) required_.push_back(key);
}

void describe(Facts& facts, const Warning& warning) {
  facts("code", warning.code, "Short name of this kind of warning.");
  facts("message", warning.message, "What is wrong, and what helps.");
}

void describe(Facts& facts, const ClearRegion& clear) {
  facts("aperture", clear.aperture ? std::optional(clear.text()) : std::nullopt,
        "The requested clear aperture, in words.");
  facts("centre_m", clear.aperture ? std::optional(std::array{clear.x, clear.y}) : std::nullopt,
        "Its centre in the coordinates of the file.");
  facts("taken_out", clear.taken_out, "Number of samples that were left out.");
  facts.if_any("said_invalid", clear.said_invalid,
               "Number of samples with a value of `invalid`, which are holes.");
}

std::optional<ClearRegion> used_part(const ClearRegion& clear) {
  const bool whole = !clear.aperture && clear.taken_out == 0 && !clear.said_invalid;
  return whole ? std::nullopt : std::optional(clear);
}

void describe_head(Facts& facts, const std::string& kind) {
  facts("aberfit", 1, "Version of the format.");
  facts.word("kind", kind, "Kind of result.");
}

}  // namespace aberfit::internal
