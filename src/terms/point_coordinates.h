#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <variant>

#include "aberfit/scene/pupil.h"
#include "point_block.h"

namespace aberfit::internal {

/// Point coordinates: lists of x and y, or a pupil's structure (8 bytes a point on a grid, none on rings).
class PointCoordinates {
 public:
  PointCoordinates(Eigen::ArrayXd x, Eigen::ArrayXd y);
  /// Stores cosines and sines of spokes and turns; their products are coordinates to 2e-16 of the ring's
  /// radius.
  explicit PointCoordinates(const PolarRings& rings);
  explicit PointCoordinates(CartesianGrid grid);

  Eigen::Index size() const { return size_; }
  /// If true, Zernike terms outside their circle take the values of its rim.
  bool hold_at_rim = false;

  /// Writes x / unit and y / unit of `used` points to the block, and zeros to the other entries. The points
  /// are rays[begin + i], or begin + i if rays is null.
  void gather(const std::uint32_t* rays, Eigen::Index begin, int used, double unit, PointBlock* block) const;

 private:
  struct Scattered {
    Eigen::ArrayXd x, y;
  };
  struct Rings {
    Eigen::ArrayXd ring_x, ring_y;  // rho e^(i turn) [m]
    Eigen::ArrayXd spoke_cos, spoke_sin;
  };
  Eigen::Index size_ = 0;
  std::variant<Scattered, Rings, CartesianGrid> points_;
};

}  // namespace aberfit::internal
