#pragma once

namespace aberfit::internal {

/// Points one kernel call works on: few enough that a block and its scratch stay in the first-level cache.
constexpr int kBlockPoints = 256;

/// Coordinates of a block of points with, for the forward map, the field that terms are added to and, for the
/// adjoint, the weights. Unused places at the end hold zeros: a point at the vertex with weight zero.
struct PointBlock {
  int used = 0;                        ///< points
  alignas(64) double x[kBlockPoints];  ///< [m], or in units of the radius where a kernel says so
  alignas(64) double y[kBlockPoints];
  alignas(64) double height[kBlockPoints];
  alignas(64) double slope_x[kBlockPoints];
  alignas(64) double slope_y[kBlockPoints];
};

}  // namespace aberfit::internal
