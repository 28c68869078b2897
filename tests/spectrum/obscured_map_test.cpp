// If a hole is too large to be bridged, as in an annulus, the PSD is estimated beside it.
#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit {
namespace {

using Eigen::Index;

// 60 x 60 points with a pitch of 1 mm and a hole of `size` x `size` points in the middle.
HeightMap with_hole(Index size) {
  HeightMap map;
  map.pitch_x = map.pitch_y = 1e-3;
  map.height = Grid::Random(60, 60);
  map.height.block(30 - size / 2, 30 - size / 2, size, size) = std::nan("");
  return map;
}

double ordinates(const HeightMap& map) { return estimate_psd(map, {}).count.sum(); }

// A hole of 169 of 3,600 points (below 5 %) is bridged; beside one of 196 points 23 x 60 remain.
TEST(ObscuredMap, HolesOfMoreThanFivePercentAreAvoided) {
  EXPECT_GT(ordinates(with_hole(13)), 0.9 * ordinates(with_hole(0)));
  EXPECT_LT(ordinates(with_hole(14)), 0.4 * ordinates(with_hole(0)));
}

// Expected bins over the PSD f^-3 itself.
TEST(ObscuredMap, BinsOfAnAnnulusAreThoseOfTheSurface) {
  HeightMap map = with_hole(0);
  centre_on_grid(&map);
  for (Index r = 0; r < 60; ++r)
    for (Index c = 0; c < 60; ++c) {
      const double rho = std::hypot(map.x(c), map.y(r));
      if (rho > 29.6e-3 || rho < 9e-3) map.height(r, c) = std::nan("");
    }
  const PsdEstimate estimate = estimate_psd(map, {});
  const Eigen::ArrayXd truth = estimate.frequency.pow(-3),
                       seen = (estimate.response * estimate.node_frequency.array().pow(-3).matrix()).array();
  int faithful = 0;
  for (Index b = 0; b < truth.size(); ++b) faithful += std::abs(std::log(seen[b] / truth[b])) < std::log(2.0);
  EXPECT_GE(faithful, 0.8 * double(truth.size())) << (seen / truth).transpose();
}

}  // namespace
}  // namespace aberfit
