#pragma once
#include <array>

#include "aberfit/measured/height_map.h"

namespace aberfit::test {

/// Height between the points of a map with this pitch [m] and the origin in its middle, by Catmull-Rom
/// splines. Error 1e-4 of the RMS for maps of 20 points per correlation length.
inline double height_between(const HeightMap& map, double pitch, double x, double y) {
  const auto weights = [](double t) {
    return std::array<double, 4>{0.5 * t * (t * (2 - t) - 1), 0.5 * (t * t * (3 * t - 5) + 2),
                                 0.5 * t * (t * (4 - 3 * t) + 1), 0.5 * t * t * (t - 1)};
  };
  const double u = x / pitch + 0.5 * double(map.height.cols()),
               v = y / pitch + 0.5 * double(map.height.rows());
  const auto i = Eigen::Index(u), j = Eigen::Index(v);
  const auto across = weights(u - double(i)), along = weights(v - double(j));
  double sum = 0;
  for (Eigen::Index b = 0; b < 4; ++b)
    for (Eigen::Index a = 0; a < 4; ++a)
      sum += along[std::size_t(b)] * across[std::size_t(a)] * map.height(j + b - 1, i + a - 1);
  return sum;
}

}  // namespace aberfit::test
