#pragma once
#include "aberfit/measured/height_map.h"
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// A map moved to the axis, its clear part in the same coordinates, and its warnings.
struct LoadedMap {
  HeightMap map;
  ClearRegion clear;
  Warnings warnings;
};
LoadedMap load_map(const Study& study);

}  // namespace aberfit::internal
