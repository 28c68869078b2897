#include "round_image.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace aberfit::internal {

Eigen::ArrayXXd round_image(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& encircled_energy,
                            double half_width, int pixels) {
  constexpr int kParts = 3;     // of a pixel's side
  constexpr int kPerPixel = 6;  // radii tabulated: the edges of the annuli of the middle row, and more
  const double pixel = 2 * half_width / pixels, step = pixel / kPerPixel;
  const auto last = Eigen::Index(std::ceil((std::numbers::sqrt2 * half_width + pixel) / step)) + 1;
  const Eigen::ArrayXd energy =
      encircled_energy(Eigen::ArrayXd::LinSpaced(last + 1, 0.0, double(last) * step));
  const auto within = [&](double radius) {
    const double at = radius / step;
    const Eigen::Index k = std::min(Eigen::Index(at), last - 1);
    return energy[k] + (at - double(k)) * (energy[k + 1] - energy[k]);
  };
  const double part = pixel / kParts;
  Eigen::ArrayXXd image = Eigen::ArrayXXd::Zero(pixels, pixels);
  for (int row = 0; row < kParts * pixels; ++row) {
    for (int column = 0; column < kParts * pixels; ++column) {
      const double x = (column + 0.5) * part - half_width, y = (row + 0.5) * part - half_width;
      const double radius = std::hypot(x, y), outer = radius + 0.5 * part;
      const double inner = std::max(0.0, radius - 0.5 * part);
      image(row / kParts, column / kParts) += part * part * (within(outer) - within(inner)) /
                                              (std::numbers::pi * (outer * outer - inner * inner));
    }
  }
  return image;
}

}  // namespace aberfit::internal
