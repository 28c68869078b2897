#pragma once
#include <optional>
#include <string>

#include "aberfit/method/outcome.h"
#include "aberfit/report/page.h"

namespace aberfit::internal {

// These functions add parts of the page of a fit.
void add_band(Page* page, const BandShares& shares, const std::optional<ScatterOfRest>& scatter,
              const EquivalentSurface& surface);
/// points_name: heading of the column of pupil points, "rays" or "cells".
void add_frontier(Page* page, const Frontier& frontier, const std::string& points_name);
void add_character(Page* page, const Character& character);
/// Adds the focus of a map, one column per surface; nothing without a map.
void add_map_light(Page* page, const FitOutcome& outcome);

/// Addition to `verdict` in the headline: "the PSD and shape are those of a random realisation", or "but it
/// is no realisation of this roughness: PSD 3.1 times at 12 /m".
std::string character_words(const Character& character, Verdict verdict);

}  // namespace aberfit::internal
