#pragma once

namespace aberfit::internal {

/// Points per kernel call; a block and its scratch memory fit the first-level cache.
constexpr int kBlockPoints = 256;

/// Coordinates of a block of points. In the forward map it also holds the field to which terms are added; in
/// the adjoint it holds the weights. Unused entries are zero, i.e. a point at the vertex with weight zero.
struct PointBlock {
  int used = 0;                        ///< points
  alignas(64) double x[kBlockPoints];  ///< [m], or in units of the radius if a kernel requires it
  alignas(64) double y[kBlockPoints];
  alignas(64) double height[kBlockPoints];
  alignas(64) double slope_x[kBlockPoints];
  alignas(64) double slope_y[kBlockPoints];
};

}  // namespace aberfit::internal
