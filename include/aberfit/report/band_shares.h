#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "aberfit/method/outcome.h"

namespace aberfit {

/// `split` of a result: where the band is cut, both parts and their sum (in squares), the spread that is
/// left, and how to use the pair; `map_residual` of a measured part. SI units. scatter, surface: of a fit.
nlohmann::ordered_json to_json(const BandShares& shares, const std::optional<ScatterOfRest>& scatter,
                               const std::optional<EquivalentSurface>& surface);

/// The same for people.
std::string band_lines(const BandShares& shares, const std::optional<ScatterOfRest>& scatter,
                       const EquivalentSurface& surface);

}  // namespace aberfit
