#pragma once
#include <Eigen/Core>

#include "aberfit/measured/height_map.h"
#include "aberfit/measured/profile.h"

namespace aberfit {

/// One entry per sample, with the shape of the map; a profile has one row.
using Mask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Makes the marked samples invalid (NaN). Throws std::invalid_argument for a mask of another shape.
void take_out(Profile* profile, const Mask& marked);
void take_out(HeightMap* map, const Mask& marked);

}  // namespace aberfit
