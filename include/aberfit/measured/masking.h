#pragma once
#include <Eigen/Core>

#include "aberfit/measured/height_map.h"
#include "aberfit/measured/profile.h"

namespace aberfit {

/// One entry a sample, of the shape of a map; of a profile one row.
using Mask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Makes the marked samples invalid (NaN). Throws std::invalid_argument for a mask of another shape.
void take_out(Profile* profile, const Mask& marked);
void take_out(HeightMap* map, const Mask& marked);

}  // namespace aberfit
