#include "aberfit/theory/round_pixels.h"

#include <vector>

namespace aberfit {

Eigen::ArrayXXd round_pixels(double pixel, int pixels,
                             const std::function<double(double y, double a, double b)>& flux_through) {
  using Eigen::Index;
  // Edges of one quadrant, from the axis out. The first cell of an odd number of pixels is half a pixel.
  const bool odd = pixels % 2 == 1;
  std::vector<double> edge = {0};
  for (double at = odd ? 0.5 : 1; at <= 0.5 * pixels; ++at) edge.push_back(at * pixel);
  const Index cells = Index(edge.size()) - 1;
  Eigen::ArrayXXd flux = Eigen::ArrayXXd::Zero(cells, cells + 1);  // piece i of the line at edge j
  for (Index j = 1; j <= cells; ++j)
    for (Index i = 0; i < cells; ++i)
      flux(i, j) = flux_through(edge[std::size_t(j)], edge[std::size_t(i)], edge[std::size_t(i) + 1]);
  Eigen::ArrayXXd energy(pixels, pixels);
  const Index middle = pixels / 2;
  for (Index row = 0; row < cells; ++row) {
    for (Index column = 0; column <= row; ++column) {
      double here = flux(column, row + 1) - flux(column, row) + flux(row, column + 1) - flux(row, column);
      if (odd) here *= (row == 0 ? 2 : 1) * (column == 0 ? 2 : 1);
      for (const Index y : {middle + row, middle - row - (odd ? 0 : 1)})
        for (const Index x : {middle + column, middle - column - (odd ? 0 : 1)})
          energy(y, x) = energy(x, y) = here;
    }
  }
  return energy;
}

}  // namespace aberfit
