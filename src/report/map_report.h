#pragma once
#include <string>

#include "aberfit/method/outcome.h"
#include "json_number.h"

namespace aberfit::internal {

/// `map` of a result: the fit of a map, its three panels, and its light. outcome.map is there.
Json map_json(const FitOutcome& outcome);

/// The light of a map as people read it: one column a surface; empty without.
std::string map_light_table(const FitOutcome& outcome);

/// Names of the surfaces of a MapLight, in the order of its columns: in files, and for people.
struct MapColumnName {
  const char* key;
  const char* label;
};
inline constexpr MapColumnName kMapColumns[] = {{"measured", "measured map"},
                                                {"terms", "terms alone"},
                                                {"terms_and_residual_psd", "terms + PSD"},
                                                {"perfect", "perfect mirror"}};

}  // namespace aberfit::internal
