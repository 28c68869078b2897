#pragma once
#include <vector>

#include "aberfit/measured/height_map.h"
#include "aberfit/measured/masking.h"

namespace aberfit {

/// One exact height that many points of a map share, as padding does and rounding does not.
struct Padding {
  double height = 0;  ///< [m]
  Eigen::Index points = 0;
  Eigen::Index outside = 0;  ///< of them outside the convex hull of the points that have no such height
  Eigen::Index blocks = 0;   ///< into which they fall, joined along rows and columns
};

/// The heights that are padding rather than measured, the most frequent first. A height is one where
/// - more than 1 % of the valid points have exactly it;
/// - they are more than twice those of either height next to it in the list of all heights, which the
///   histogram of a rounded smooth distribution has only where its standard deviation is below 0.8 steps of
///   the rounding, or where the surface is level;
/// - a surface that was rounded is not left through it: of the points beside those that have it, fewer than
///   half have one of the two heights next to it, a step of the rounding away. (Of Gaussian heights with a
///   standard deviation below 0.8 steps at least 88 % have; of a level part of a surface that varies slowly
///   nearly all.)
/// - a surface does not cross it along lines, as an astigmatism crosses zero exactly on its axes. There fewer
///   than a quarter of the points have no other height beside them, and the heights beside them are no more
///   than twice as far from it as from the next ones (medians).
/// Data rounded so coarsely that they hardly leave one height, padded with that very height, are not told
/// from level ones: nothing is found there. Of a constant map nothing is found either.
std::vector<Padding> find_padding(const HeightMap& map);

/// The points that have one of these heights.
Mask padded_points(const HeightMap& map, const std::vector<Padding>& padding);

}  // namespace aberfit
