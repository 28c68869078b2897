#include "focal_bins.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/quadrature.h"

namespace aberfit::internal {
namespace {

constexpr int kOffsets = 4;      // Gauss nodes over half of a pixel
constexpr int kDirections = 64;  // points along a circle
constexpr int kOfSide = 4;       // Gauss nodes along the side of a pixel
constexpr int kOfNearSide = 12;  // for a side near the centre, along which the angle varies fast
constexpr double kNear = 3;      // distance from the centre in pixel sides
constexpr double kRingGrowth = 0.125;
// Largest outer radius of rings in which each pixel is a separate datum [pixels].
constexpr double kEachPixel = 3;
constexpr double kLeastWindow = 3;  // pixels

// Converts weights of E at any radius to weights at even steps by polynomials of fifth degree. E is even in
// the radius, so that the interpolation continues through the centre.
class EnergyNodes {
 public:
  explicit EnergyNodes(double step) : step_(step) {}

  void add(Eigen::Index datum, double radius, double weight) {
    constexpr int kPoints = 6;
    const double t = radius / step_;
    const long first = long(std::floor(t)) - 2;
    for (int i = 0; i < kPoints; ++i) {
      double factor = weight;
      for (int j = 0; j < kPoints; ++j)
        if (j != i) factor *= (t - double(first + j)) / double(i - j);
      sums_[std::abs(first + i)][datum] += factor;
    }
  }
  void write(FocalBins* bins, Eigen::Index data) {
    sums_.erase(0);  // E is 0 at the centre
    bins->nodes.resize(Eigen::Index(sums_.size()));
    bins->weights.setZero(data, bins->nodes.size());
    Eigen::Index node = 0;
    for (const auto& [step, of_data] : sums_) {
      bins->nodes[node] = step_ * double(step);
      for (const auto& [datum, weight] : of_data) bins->weights(datum, node) = weight;
      ++node;
    }
  }

 private:
  double step_;
  std::map<long, std::map<Eigen::Index, double>> sums_;
};

// Step of E: ten per period of its finest ripple, but not finer than a pixel resolves.
double step_of(double pixel, double resolution) { return std::max(resolution / 10, pixel / 16); }

// Ring of each pixel, -1 for none.
struct RingOfPixel {
  Eigen::ArrayXXi ring;
  std::vector<double> edges;  // outer radii [pixels]
};

RingOfPixel rings_about(const Grid& light, double x, double y, double reach) {
  RingOfPixel result;
  for (double edge = 1; edge <= reach; edge = std::max(edge + 1, edge * (1 + kRingGrowth)))
    result.edges.push_back(edge);
  result.ring.setConstant(light.rows(), light.cols(), -1);
  if (result.edges.empty()) return result;
  for (Eigen::Index row = 0; row < light.rows(); ++row)
    for (Eigen::Index column = 0; column < light.cols(); ++column) {
      const double radius = std::hypot(double(column) - x, double(row) - y);
      const auto at = std::lower_bound(result.edges.begin(), result.edges.end(), radius);
      if (at != result.edges.end() && std::isfinite(light(row, column)))
        result.ring(row, column) = int(at - result.edges.begin());
    }
  return result;
}

// Adds the angle about the origin along one straight side.
void add_side(EnergyNodes* nodes, int left, int right, double x0, double y0, double x1, double y1,
              double pixel) {
  const double middle = std::hypot(0.5 * (x0 + x1), 0.5 * (y0 + y1));
  const Quadrature rule = gauss_legendre(middle < kNear ? kOfNearSide : kOfSide, 0, 1);
  for (Eigen::Index k = 0; k < rule.nodes.size(); ++k) {
    const double t = rule.nodes[k], x = x0 + t * (x1 - x0), y = y0 + t * (y1 - y0);
    const double square = std::max(x * x + y * y, 1e-18);
    const double turn = rule.weights[k] * (x * (y1 - y0) - y * (x1 - x0)) / square / (2 * kPi);
    const double radius = pixel * std::sqrt(square);
    if (left >= 0) nodes->add(left, radius, turn);
    if (right >= 0) nodes->add(right, radius, -turn);
  }
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<double> values_at_rim(const Grid& light) {
  const Eigen::Index width = std::max<Eigen::Index>(1, std::min(light.rows(), light.cols()) / 10);
  std::vector<double> values;
  for (Eigen::Index row = 0; row < light.rows(); ++row)
    for (Eigen::Index column = 0; column < light.cols(); ++column) {
      const Eigen::Index to_side = std::min({row, column, light.rows() - 1 - row, light.cols() - 1 - column});
      if (to_side < width && std::isfinite(light(row, column))) values.push_back(light(row, column));
    }
  return values;
}

}  // namespace

// Centroid under a Gaussian window that follows it: unbiased for a symmetric spot and insensitive to noise
// far out. The window is as wide as the spot at half maximum, but wide enough to hide the pixel grid.
PixelPlace centre_of(const FocalImage& image) {
  const Grid& light = image.light;
  const std::vector<double> rim = values_at_rim(light);
  const double background = rim.empty() ? 0 : median(rim);
  Eigen::Index row = 0, column = 0;
  double peak = -kInfinity;
  for (Eigen::Index r = 1; r + 1 < light.rows(); ++r)
    for (Eigen::Index c = 1; c + 1 < light.cols(); ++c) {
      const double around = light.block(r - 1, c - 1, 3, 3).sum();
      if (around > peak) peak = around, row = r, column = c;
    }
  const double top = peak / 9 - background;
  if (!(top > 0))
    throw FieldError("solve.focus.file", "an image that is nowhere brighter than its rim",
                     "an image of the focus with background around it");
  const double bright = double((light - background > 0.5 * top).count());
  const double window = std::max(kLeastWindow, std::sqrt(bright / kPi));
  double x = double(column), y = double(row);
  for (int iteration = 0; iteration < 100; ++iteration) {
    double weights = 0, sum_x = 0, sum_y = 0;
    for (Eigen::Index r = 0; r < light.rows(); ++r)
      for (Eigen::Index c = 0; c < light.cols(); ++c) {
        const double dx = double(c) - x, dy = double(r) - y, square = dx * dx + dy * dy;
        if (square > 16 * window * window || !std::isfinite(light(r, c))) continue;
        const double weight = (light(r, c) - background) * std::exp(-square / (2 * window * window));
        weights += weight, sum_x += weight * dx, sum_y += weight * dy;
      }
    if (!(weights > 0)) break;
    // A full step is right for a spot much finer than the window, half of it for one as wide; both converge.
    const double step_x = sum_x / weights, step_y = sum_y / weights;
    x += step_x, y += step_y;
    if (std::hypot(step_x, step_y) < 1e-5) break;
  }
  return {x, y};
}

FocalBins circles_of(const EncircledCurve& curve, double pixel, double resolution) {
  FocalBins bins;
  bins.radius = curve.radius;
  bins.measured = curve.share;
  bins.pixels.setZero(curve.radius.size());
  bins.edges = curve.radius;
  for (int k = 0; k < int(curve.radius.size()); ++k) bins.ring_of.push_back(k);
  const Eigen::Index count = curve.radius.size();
  if (pixel == 0) {
    bins.nodes = curve.radius;
    bins.weights.setIdentity(count, count);
    return bins;
  }
  // Counts pixels with their centres within r for any position of the pixel grid. On average this is the
  // energy within the circle, shifted by all points of a pixel.
  EnergyNodes nodes(step_of(pixel, resolution));
  const Quadrature offsets = gauss_legendre(kOffsets, 0, 0.5 * pixel);
  for (Eigen::Index k = 0; k < count; ++k)
    for (Eigen::Index i = 0; i < kOffsets; ++i)
      for (Eigen::Index j = 0; j < kOffsets; ++j)
        for (int direction = 0; direction < kDirections; ++direction) {
          const double phi = 2 * kPi * (direction + 0.5) / kDirections, r = curve.radius[k];
          const double along = offsets.nodes[i] * std::cos(phi) + offsets.nodes[j] * std::sin(phi);
          const double square =
              r * r + 2 * r * along + std::pow(offsets.nodes[i], 2) + std::pow(offsets.nodes[j], 2);
          const double share = offsets.weights[i] * offsets.weights[j] / (0.25 * pixel * pixel);
          if (square > 0) nodes.add(k, std::sqrt(square), share * (r * r + r * along) / square / kDirections);
        }
  nodes.write(&bins, count);
  return bins;
}

FocalBins rings_of(const FocalImage& image, double pixel, double resolution, double reach,
                   const PixelPlace& centre, const PixelPlace& light_centre) {
  const Grid& light = image.light;
  FocalBins bins;
  bins.are_rings = true;
  const double within = std::min(
      {centre.x, centre.y, double(light.cols() - 1) - centre.x, double(light.rows() - 1) - centre.y});
  const RingOfPixel rings = rings_about(light, centre.x, centre.y, std::min(within, reach / pixel));
  bins.edges = pixel * Eigen::Map<const Eigen::ArrayXd>(rings.edges.data(), Eigen::Index(rings.edges.size()));
  // Index of the datum of each pixel, in the order of rings.
  Eigen::ArrayXXi datum = Eigen::ArrayXXi::Constant(light.rows(), light.cols(), -1);
  std::vector<double> sums, counts, radii;
  for (int ring = 0; ring < int(rings.edges.size()); ++ring) {
    const bool each = rings.edges[std::size_t(ring)] <= kEachPixel;
    bool begun = false;
    for (Eigen::Index row = 0; row < light.rows(); ++row)
      for (Eigen::Index column = 0; column < light.cols(); ++column) {
        if (rings.ring(row, column) != ring) continue;
        if (each || !begun) {
          for (std::vector<double>* list : {&sums, &counts, &radii}) list->push_back(0);
          bins.ring_of.push_back(ring);
          begun = true;
        }
        datum(row, column) = int(sums.size()) - 1;
        sums.back() += light(row, column);
        counts.back() += 1;
        // Root-mean-square radius over the pixel, positive for the one that holds the centre.
        const double x = double(column) - centre.x, y = double(row) - centre.y;
        radii.back() += pixel * std::sqrt(x * x + y * y + 1.0 / 6);
      }
  }
  const auto array = [](const std::vector<double>& list) {
    return Eigen::Map<const Eigen::ArrayXd>(list.data(), Eigen::Index(list.size()));
  };
  bins.measured = array(sums);
  bins.pixels = array(counts);
  bins.radius = array(radii) / bins.pixels;
  // Sides between pixels of the same datum cancel.
  EnergyNodes nodes(step_of(pixel, resolution));
  const auto datum_at = [&](Eigen::Index row, Eigen::Index column) {
    const bool inside = row >= 0 && column >= 0 && row < light.rows() && column < light.cols();
    return inside ? datum(row, column) : -1;
  };
  for (Eigen::Index row = 0; row <= light.rows(); ++row)
    for (Eigen::Index column = 0; column <= light.cols(); ++column) {
      const double left = double(column) - 0.5 - light_centre.x, low = double(row) - 0.5 - light_centre.y;
      const int here = datum_at(row, column), below = datum_at(row - 1, column),
                before = datum_at(row, column - 1);
      // Along x the pixel above is on the left; along y the previous pixel.
      if (here != below) add_side(&nodes, here, below, left, low, left + 1, low, pixel);
      if (here != before) add_side(&nodes, before, here, left, low, left, low + 1, pixel);
    }
  nodes.write(&bins, bins.measured.size());
  return bins;
}

double noise_of_rim(const FocalImage& image) {
  std::vector<double> values = values_at_rim(image.light);
  if (values.size() < 10) return 0;
  const double middle = median(values);
  for (double& value : values) value = std::abs(value - middle);
  return 1.4826 * median(values);
}

}  // namespace aberfit::internal
