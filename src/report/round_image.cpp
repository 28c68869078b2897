#include "round_image.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace aberfit::internal {

Eigen::ArrayXXd round_image(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& encircled_energy,
                            double half_width, int pixels) {
  constexpr int kParts = 3;     // parts per side of a pixel
  constexpr int kPerPixel = 6;  // tabulated radii, among them the edges of the annuli of the middle row
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

namespace {

// Fraction of the energy of a round spot inside the square of this side [m]: the encircled energy at its
// edge, averaged over directions.
double share_in_square(const RoundSpot& spot, double side) {
  constexpr int kDirections = 16;  // in an eighth of the square
  double sum = 0;
  for (int i = 0; i < kDirections; ++i)
    sum += spot(0.5 * side / std::cos(std::numbers::pi / 4 * (i + 0.5) / kDirections)).energy;
  return sum / kDirections;
}

// Irradiance [1/m^2] of a round spot from a table over radii.
class RoundIrradiance {
 public:
  RoundIrradiance(const RoundSpot& spot, double first, double last) : first_(first) {
    constexpr Eigen::Index kSteps = 256;
    step_ = (last - first) / double(kSteps);
    value_.resize(kSteps + 1);
    for (Eigen::Index k = 0; k <= kSteps; ++k) {
      const double radius = first + double(k) * step_;
      value_[k] = spot(radius).slope / (2 * std::numbers::pi * radius);
    }
  }
  double operator()(double radius) const {
    const double at = std::max(0.0, (radius - first_) / step_);
    const Eigen::Index k = std::min(Eigen::Index(at), value_.size() - 2);
    return value_[k] + (at - double(k)) * (value_[k + 1] - value_[k]);
  }

 private:
  double first_, step_;
  Eigen::ArrayXd value_;
};

// Middle and length of the part of each pixel that lies in the field of view.
struct Seen {
  Eigen::ArrayXd middle, length;
};
Seen seen_part(double field_of_view, double half_width, Eigen::Index pixels) {
  const double pixel = 2 * half_width / double(pixels);
  const Eigen::ArrayXd left = Eigen::ArrayXd::LinSpaced(pixels, 0.0, double(pixels - 1)) * pixel - half_width;
  const Eigen::ArrayXd from = left.max(-0.5 * field_of_view), to = (left + pixel).min(0.5 * field_of_view);
  return {0.5 * (from + to), (to - from).max(0.0)};
}

}  // namespace

Eigen::ArrayXXd unfolded(const Eigen::ArrayXXd& periodic, const RoundSpot& mean, double field_of_view,
                         double half_width) {
  constexpr double kNegligible = 1e-6;  // fraction of the energy
  constexpr int kPeriods = 5;           // on each side; beyond them irradiance is uniform over a period
  const double beyond = 1 - share_in_square(mean, field_of_view);
  if (beyond < kNegligible) return periodic;
  const double covered = (2 * kPeriods + 1) * field_of_view;
  const RoundIrradiance irradiance(mean, 0.5 * field_of_view, std::numbers::sqrt2 * 0.5 * covered);
  const double even = (1 - share_in_square(mean, covered)) / (field_of_view * field_of_view);
  const Eigen::Index pixels = periodic.rows();
  const Seen seen = seen_part(field_of_view, half_width, pixels);
  const auto folded = [&](double x, double y) {
    double sum = even;
    for (int i = -kPeriods; i <= kPeriods; ++i)
      for (int j = -kPeriods; j <= kPeriods; ++j)
        if (i != 0 || j != 0) sum += irradiance(std::hypot(x + i * field_of_view, y + j * field_of_view));
    return sum;
  };
  const double pixel = 2 * half_width / double(pixels);
  const bool sees_all = half_width * (1 + 1e-9) >= 0.5 * field_of_view;
  Eigen::ArrayXXd image = periodic;
  if (sees_all) {
    const auto energy = [&](const Eigen::ArrayXd& radii) -> Eigen::ArrayXd {
      return radii.unaryExpr([&](double radius) { return mean(radius).energy; });
    };
    const Eigen::ArrayXXd spot = round_image(energy, half_width, int(pixels));
    const Eigen::ArrayXd share = seen.length / pixel;
    image += spot * (1 - (share.matrix() * share.matrix().transpose()).array());
  }
  Eigen::ArrayXXd excess = Eigen::ArrayXXd::Zero(pixels, pixels);
  for (Eigen::Index row = 0; row < pixels; ++row)
    for (Eigen::Index column = 0; column < pixels; ++column)
      if (const double area = seen.length[row] * seen.length[column]; area > 0)
        excess(row, column) = area * folded(seen.middle[column], seen.middle[row]);
  // Pixels are coarse for a narrow field of view, so we scale their sum to the aliased energy. Energy that a
  // sharp edge diffracts beyond the field of view does not count, because the pupil grid lacks it.
  if (sees_all) excess *= std::max(0.0, periodic.sum() + beyond - 1) / excess.sum();
  return (image - excess).max(0.0);
}

}  // namespace aberfit::internal
