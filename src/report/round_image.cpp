#include "round_image.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "aberfit/core/quadrature.h"
#include "aberfit/theory/round_pixels.h"

namespace aberfit::internal {

namespace {

using EnergyWithin = std::function<Eigen::ArrayXd(const Eigen::ArrayXd& radii)>;

// E(r)/r^2 of light that an aperture diffracts, as polynomials over t = asinh(r/detail). A piece is halved
// until its last coefficients are below the tolerance, or it is so short that it has the finest ripples: half
// of `detail`, and far out, where only what scatters at one frequency can be as sharp, a 2000th of the
// radius.
class EnergyPerSquare {
 public:
  EnergyPerSquare(const EnergyWithin& energy, double detail, double farthest) : detail_(detail) {
    constexpr double kTolerance = 1e-7;  // of the energy; the mean spot itself is interpolated to 2e-6
    const Eigen::ArrayXd node =
        -(Eigen::ArrayXd::LinSpaced(kNodes, 0.5, kNodes - 0.5) * (std::numbers::pi / kNodes)).cos();
    Eigen::MatrixXd transform(kNodes, kNodes);
    for (int k = 0; k < kNodes; ++k)
      transform.row(k) = (k == 0 ? 1.0 : 2.0) / kNodes * (k * node.acos()).cos().matrix().transpose();
    std::vector<Piece> waiting;
    const double last = std::asinh(farthest / detail);
    const int first_pieces = 1 + int(2 * last);
    for (int k = 0; k < first_pieces; ++k)
      waiting.push_back({last * k / first_pieces, last * (k + 1) / first_pieces, {}});
    while (!waiting.empty()) {
      Eigen::ArrayXd radii(Eigen::Index(waiting.size()) * kNodes);
      for (std::size_t k = 0; k < waiting.size(); ++k)
        radii.segment(Eigen::Index(k) * kNodes, kNodes) =
            detail * (waiting[k].middle() + waiting[k].half() * node).sinh();
      const Eigen::ArrayXd value = energy(radii) / radii.square();
      std::vector<Piece> halves;
      for (std::size_t k = 0; k < waiting.size(); ++k) {
        Piece& piece = waiting[k];
        piece.coefficient = transform * value.segment(Eigen::Index(k) * kNodes, kNodes).matrix();
        const double end = detail * std::sinh(piece.to), length = end - detail * std::sinh(piece.from);
        const double error = piece.coefficient.tail<2>().lpNorm<1>() * end * end;
        if (error < kTolerance || length < 0.5 * std::hypot(detail, 1e-3 * end)) {
          pieces_.push_back(piece);
        } else {
          halves.push_back({piece.from, piece.middle(), {}});
          halves.push_back({piece.middle(), piece.to, {}});
        }
      }
      waiting = std::move(halves);
    }
    std::sort(pieces_.begin(), pieces_.end(), [](const Piece& a, const Piece& b) { return a.from < b.from; });
  }

  double operator()(double radius) const {
    const double t = std::asinh(radius / detail_);
    const auto after = std::upper_bound(pieces_.begin() + 1, pieces_.end(), t,
                                        [](double value, const Piece& piece) { return value < piece.from; });
    const Piece& piece = *(after - 1);
    const double x = (t - piece.middle()) / piece.half();  // Clenshaw's sum
    double one = 0, two = 0;
    for (int k = kNodes - 1; k > 0; --k) two = std::exchange(one, piece.coefficient[k] + 2 * x * one - two);
    return piece.coefficient[0] + x * one - two;
  }

 private:
  // With 8 to 16 nodes the errors for the Airy pattern stay below 2e-7, and evaluations differ by a factor 2.
  static constexpr int kNodes = 10;
  struct Piece {
    double from, to;  // of t
    Eigen::Matrix<double, kNodes, 1> coefficient;
    double middle() const { return 0.5 * (from + to); }
    double half() const { return 0.5 * (to - from); }
  };
  double detail_;  // [m]
  std::vector<Piece> pieces_;
};

// The flux of that energy through a piece of an edge, see round_pixels.
class DiffractedFlux {
 public:
  DiffractedFlux(const EnergyWithin& energy, double detail, double farthest)
      : detail_(detail), per_square_(energy, detail, farthest) {}

  double operator()(double y, double a, double b) const {
    const double resolved = std::hypot(detail_, 1e-3 * std::hypot(a, y));
    const int pieces = int(std::ceil((b - a) / resolved));
    const double half = 0.5 * (b - a) / pieces;
    double sum = 0;
    for (int k = 0; k < pieces; ++k) {
      const double middle = a + (2 * k + 1) * half;
      for (Eigen::Index i = 0; i < rule_.nodes.size(); ++i)
        sum += half * rule_.weights[i] * per_square_(std::hypot(middle + half * rule_.nodes[i], y));
    }
    return sum * y / (2 * std::numbers::pi);
  }

 private:
  double detail_;  // [m]
  EnergyPerSquare per_square_;
  Quadrature rule_ = gauss_legendre(8, -1, 1);
};

}  // namespace

Eigen::ArrayXXd round_image(const EnergyWithin& encircled_energy, double detail, double half_width,
                            int pixels) {
  return round_pixels(2 * half_width / pixels, pixels,
                      DiffractedFlux(encircled_energy, detail, std::numbers::sqrt2 * half_width));
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

Eigen::ArrayXXd unfolded(const Eigen::ArrayXXd& periodic, const RoundSpot& mean, double detail,
                         double field_of_view, double half_width) {
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
    const Eigen::ArrayXXd spot = round_image(energy, detail, half_width, int(pixels));
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
