#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "aberfit/method/frontier.h"

namespace aberfit {

nlohmann::ordered_json to_json(const Frontier& frontier);
nlohmann::ordered_json to_json(const RayChoice& rays);
nlohmann::ordered_json to_json(const BandUse& band);

/// What the summary says: one paragraph, and up to 12 rows of the sets next to the chosen one.
/// points_name: heads the column of pupil points, "rays" or "cells".
std::string frontier_lines(const Frontier& frontier, const std::string& points_name);

}  // namespace aberfit
