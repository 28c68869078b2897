#include "aberfit/theory/halo_kernel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/theory/round_pixels.h"

namespace aberfit {
namespace {

using Eigen::Index;

// The energy scattered to within a radius, over a range of radii [direction cosines]. It is interpolated in
// the logarithm of the radius by cubics with the exact slope 2 pi r^2 BSDF, between the bends of E. With 300
// nodes a decade the kernel has the errors that its header states.
class EnergyWithin {
 public:
  EnergyWithin(const ScatterFunction& scatter, std::vector<double> bends, double least, double most) {
    constexpr double kNodesPerDecade = 300;
    most = std::min(most, 1.0);
    bends.push_back(least);
    bends.push_back(most);
    std::sort(bends.begin(), bends.end());
    const auto slope = [&](double r) { return kTwoPi * r * r * scatter.bsdf(std::asin(std::min(r, 1.0))); };
    for (std::size_t k = 0; k + 1 < bends.size(); ++k) {
      const double from = std::max(bends[k], least), to = std::min(bends[k + 1], most);
      if (!(to > from * (1 + 1e-9))) continue;
      const int pieces = 1 + int(kNodesPerDecade * std::log10(to / from));
      for (int i = 0; i <= pieces; ++i) {
        const double r = from * std::pow(to / from, double(i) / pieces);
        const double beside = i == 0 ? r * (1 + 1e-10) : i == pieces ? r * (1 - 1e-10) : r;  // of a jump
        nodes_.push_back({std::log(r), scatter.within(std::asin(std::min(r, 1.0))), slope(beside)});
      }
    }
    end_ = scatter.tis();
  }

  double operator()(double r) const {
    if (r >= 1 || nodes_.empty()) return end_;
    const double t = std::log(r);
    const auto after = std::upper_bound(nodes_.begin(), nodes_.end(), t,
                                        [](double value, const Node& node) { return value < node.t; });
    if (after == nodes_.begin()) return nodes_.front().energy;
    if (after == nodes_.end()) return nodes_.back().energy;
    const Node &one = *(after - 1), &two = *after;
    const double h = two.t - one.t, u = (t - one.t) / h, v = 1 - u;
    return v * v * (1 + 2 * u) * one.energy + u * u * (1 + 2 * v) * two.energy +
           h * u * v * (v * one.slope - u * two.slope);
  }

 private:
  struct Node {
    double t, energy, slope;  // slope: over t
  };
  std::vector<Node> nodes_;
  double end_ = 0;
};

// The flux of E(r) r/(2 pi r^2) through pieces of lines at a distance from the axis.
class EdgeFlux {
 public:
  EdgeFlux(const ScatterFunction& scatter, double least, double most)
      : bends_(bends_of(scatter)), energy_(scatter, bends_, least, most) {}

  // Through the piece from x = a to b of the line at y > 0; all in direction cosines.
  double operator()(double y, double a, double b) const {
    std::vector<double> cuts = {a, b};
    for (const double r : bends_)
      if (const double x = std::sqrt(std::max(0.0, r * r - y * y)); x > a && x < b) cuts.push_back(x);
    std::sort(cuts.begin(), cuts.end());
    // Near the axis the integrand changes over the distance to it, farther away over many pixels.
    const Quadrature& rule = b - a < 0.25 * std::hypot(a, y) ? far_ : near_;
    double sum = 0;
    for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
      const double middle = 0.5 * (cuts[k] + cuts[k + 1]), half = 0.5 * (cuts[k + 1] - cuts[k]);
      for (Index i = 0; i < rule.nodes.size(); ++i) {
        const double x = middle + half * rule.nodes[i], r2 = x * x + y * y;
        sum += half * rule.weights[i] * energy_(std::sqrt(r2)) * y / r2;
      }
    }
    return sum / kTwoPi;
  }

 private:
  static std::vector<double> bends_of(const ScatterFunction& scatter) {
    std::vector<double> bends;
    for (const double f : scatter.psd().breakpoints())
      if (f * scatter.wavelength() < 1) bends.push_back(f * scatter.wavelength());
    return bends;
  }

  std::vector<double> bends_;  // radii at which the slope of E jumps [direction cosine]
  EnergyWithin energy_;
  Quadrature near_ = gauss_legendre(16, -1, 1), far_ = gauss_legendre(6, -1, 1);
};

}  // namespace

HaloKernel halo_kernel(const ScatterFunction& scatter, double pixel, int pixels) {
  if (!(pixel > 0) || pixels < 1 || pixels > kMostKernelPixels)
    throw std::invalid_argument(
        fmt::format("a kernel needs a pixel above 0 and 1 to {} pixels a side, not {:g} and {}",
                    kMostKernelPixels, pixel, pixels));
  HaloKernel kernel;
  kernel.pixel = pixel;
  kernel.core = 1 - scatter.tis();
  kernel.fraction.setZero(pixels, pixels);
  if (!(scatter.tis() > 0)) return kernel;

  const double first_edge = (pixels % 2 == 1 ? 0.5 : 1) * pixel;
  kernel.fraction = round_pixels(
      pixel, pixels, EdgeFlux(scatter, 0.99 * first_edge, 1.01 * std::numbers::sqrt2 * 0.5 * pixels * pixel));
  kernel.halo = kernel.fraction.sum();
  kernel.beyond = scatter.tis() - kernel.halo;
  return kernel;
}

}  // namespace aberfit
