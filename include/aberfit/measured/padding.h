#pragma once
#include <vector>

#include "aberfit/measured/height_map.h"
#include "aberfit/measured/masking.h"

namespace aberfit {

/// One exact height that many points of a map have because the file was padded with it.
struct Padding {
  double height = 0;  ///< [m]
  Eigen::Index points = 0;
  Eigen::Index outside = 0;  ///< number of these points outside the convex hull of all other points
  Eigen::Index blocks = 0;   ///< number of blocks that these points form, connected along rows and columns
};

/// Returns the heights that are padding rather than measured, the most frequent first. For such a height:
/// - More than 1 % of the valid points have exactly this height.
/// - It has more than twice as many points as either neighbour in the sorted list of heights. Rounding a
/// smooth distribution gives such a peak only below a standard deviation of 0.8 steps, or on a level surface.
/// - Of the points beside it, fewer than half are one rounding step away. On a rounded surface they are at
/// least 88 % (Gaussian, standard deviation below 0.8 steps), or nearly all (level part of a smooth surface).
/// - It is not a line that a surface crosses, such as the zero of astigmatism on its axes. On such a line
/// fewer than a quarter of the points have no other height beside them, and the neighbours are at most twice
/// as far from this height as from the next points (medians).
/// If rounding leaves hardly more than one height, padding with that height is not found. A constant map has
/// none.
std::vector<Padding> find_padding(const HeightMap& map);

/// Marks the points that have one of these heights.
Mask padded_points(const HeightMap& map, const std::vector<Padding>& padding);

}  // namespace aberfit
