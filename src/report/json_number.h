#pragma once
#include <cmath>
#include <nlohmann/json.hpp>

namespace aberfit::internal {

using Json = nlohmann::ordered_json;

/// JSON has no NaN and no infinity, so they become null.
inline Json json_number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

}  // namespace aberfit::internal
