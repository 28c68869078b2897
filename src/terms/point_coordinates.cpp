#include "point_coordinates.h"

#include <algorithm>
#include <numbers>
#include <utility>

namespace aberfit::internal {

PointCoordinates::PointCoordinates(Eigen::ArrayXd x, Eigen::ArrayXd y)
    : size_(x.size()), points_(Scattered{std::move(x), std::move(y)}) {}

PointCoordinates::PointCoordinates(const PolarRings& rings) : size_(rings.rho.size() * rings.spokes) {
  const Eigen::ArrayXd angle = Eigen::ArrayXd::LinSpaced(rings.spokes, 0.0, double(rings.spokes - 1)) *
                               (2.0 * std::numbers::pi / double(rings.spokes));
  points_ = Rings{rings.rho * rings.turn.cos(), rings.rho * rings.turn.sin(), angle.cos(), angle.sin()};
}

PointCoordinates::PointCoordinates(CartesianGrid grid)
    : size_(Eigen::Index(grid.column.size())), points_(std::move(grid)) {}

void PointCoordinates::gather(const std::uint32_t* rays, Eigen::Index begin, int used, double unit,
                              PointBlock* block) const {
  const auto point = [&](int i) { return rays ? Eigen::Index(rays[begin + i]) : begin + i; };
  if (const auto* scattered = std::get_if<Scattered>(&points_)) {
    for (int i = 0; i < used; ++i) block->x[i] = scattered->x[point(i)] / unit;
    for (int i = 0; i < used; ++i) block->y[i] = scattered->y[point(i)] / unit;
  } else if (const auto* rings = std::get_if<Rings>(&points_)) {
    const Eigen::Index spokes = rings->spoke_cos.size();
    for (int i = 0; i < used; ++i) {
      const Eigen::Index at = point(i), ring = at / spokes, spoke = at - ring * spokes;
      const double a = rings->ring_x[ring] / unit, b = rings->ring_y[ring] / unit;
      const double cosine = rings->spoke_cos[spoke], sine = rings->spoke_sin[spoke];
      block->x[i] = a * cosine - b * sine;
      block->y[i] = a * sine + b * cosine;
    }
  } else {
    const auto& grid = std::get<CartesianGrid>(points_);
    for (int i = 0; i < used; ++i) {
      const auto at = std::size_t(point(i));
      block->x[i] = grid.x[Eigen::Index(grid.column[at])] / unit;
      block->y[i] = grid.y[Eigen::Index(grid.row[at])] / unit;
    }
  }
  std::fill(block->x + used, block->x + kBlockPoints, 0.0);
  std::fill(block->y + used, block->y + kBlockPoints, 0.0);
}

}  // namespace aberfit::internal
