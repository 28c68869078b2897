#pragma once
#include "aberfit/measured/height_map.h"
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// The map, moved to the axis, and what is to be said of it; the terms that are fitted to it.
HeightMap load_map(const Study& study, Warnings* warnings);
TermSet map_terms(const Study& study, double radius);

}  // namespace aberfit::internal
