#include "aberfit/focus/circles_of_square.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/constants.h"

namespace aberfit {

Quadrature circles_of_square(double turn) {
  constexpr double kLeastNodes = 12, kMostNodes = 512, kNodesPerRadian = 0.5;
  const double along_edge = 0.5 * (std::numbers::sqrt2 - 1) * turn;
  Quadrature circles =
      gauss_legendre(int(std::min(kMostNodes, kLeastNodes + kNodesPerRadian * along_edge)), 0, kPi / 4);
  circles.nodes = 0.5 / circles.nodes.cos();
  circles.weights *= 4 / kPi;
  return circles;
}

}  // namespace aberfit
