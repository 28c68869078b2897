#include "higher_orders.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "surface_transfer.h"

namespace aberfit::internal {
namespace {

// Cycles of an octave's lowest frequency at which its taper falls to a half; it ends at twice as many. It
// rounds a kink of power 3/2 over 1/200 of its frequency.
constexpr double kTaperCycles = 200;
constexpr double kTaperSteepness = 6;  // erfc(6) = 2e-17 is left at both ends
// Cycles of the highest frequency from which the band edge is softened, completely at twice as many.
constexpr double kSharpEdgeCycles = 200;
constexpr double kSmallestOfWavelength = 1e-6;  // smallest lag that needs resolving

double taper(double z) { return 0.5 * std::erfc(kTaperSteepness * (z - 1)); }

// Weights -1 0 9 16 9 0 -1: the mean has the response (1 - y)^2 (1 + 2 y), y = sin^2(pi f/(2 f_max)). It is
// flat to the fourth power at low frequencies and zero at the edge.
constexpr EdgeSoftening kFlatSoftening{kSharpEdgeCycles, 1, 3, 16, 9, -1};

}  // namespace

double higher_order_transfer(double g2, double e) {
  if (std::isinf(g2)) return std::exp(-e);
  const double q = g2 - e, core = std::exp(-g2);
  if (std::abs(q) < 0.1) {
    double term = 0.5 * q * q, sum = term;
    for (int n = 3; std::abs(term) > 1e-17 * sum; ++n) {
      term *= q / n;
      sum += term;
    }
    return core * sum;
  }
  // exp(q) overflows long after the core has vanished.
  return g2 < 600 ? core * (std::expm1(q) - q) : std::exp(-e);
}

HigherOrders::HigherOrders(const RadialPsd& psd, double wavelength, double g, double lowest)
    : wavelength_(wavelength), light_(higher_order_transfer(g * g, 0)) {
  const double k = 4 * kPi / wavelength;
  const int octaves = std::max(1, int(std::ceil(-std::log2(lowest * wavelength) - 1e-9)));
  const auto lower_end = [&](int octave) { return std::ldexp(1 / wavelength, -octave - 1); };
  reach_ = 2 * kTaperCycles / lower_end(octaves - 1);
  if (!(light_ > 0)) return;  // g^4 underflows
  SurfaceTransferOptions options;
  options.cutoff = reach_;
  for (const double x : {kSharpEdgeCycles / psd.f_max(), 2 * kSharpEdgeCycles / psd.f_max()})
    if (x > 0 && x < reach_) options.breakpoints.push_back(x);
  options.breakpoints.push_back(reach_);
  options.smallest = kSmallestOfWavelength * wavelength;
  // The panels take T over its value at 0 in place of exp(-E); -log T is infinite where T is 0.
  const auto exponent = [&](const Eigen::ArrayXd& x) {
    Eigen::ArrayXd e = k * k * softened_structure(psd, x, kFlatSoftening);
    for (double& value : e) value = -std::log(higher_order_transfer(g * g, std::max(0.0, value)) / light_);
    return e;
  };
  SurfaceTransfer transfer = surface_transfer(exponent, kInfinity, options);
  unresolved_ = transfer.unresolved;
  for (int i = 0; i < octaves; ++i) {
    const double half = kTaperCycles / lower_end(i) / reach_;  // in units of reach_
    std::vector<TransferPanel> tapered;
    for (const TransferPanel& panel : transfer.panels)
      if (panel.a < 2 * half)
        append_product(
            panel, [&](double s) { return taper(s / half); }, &tapered);
    octaves_.emplace_back(std::move(tapered));
  }
}

const RadialTransform& HigherOrders::octave(double f) const {
  const double below = f > 0 ? -std::log2(f * wavelength_) : kInfinity;
  const double last = double(octaves_.size()) - 1;
  return octaves_[std::size_t(std::clamp(std::floor(below), 0.0, last))];
}

double HigherOrders::density(double f) const {
  if (octaves_.empty()) return 0;
  const RadialTransform& transform = octave(f);
  const double v = kTwoPi * f * reach_;
  const double integral = v > 0 ? transform.disc(v).derivative / v : transform.first_moment();
  return std::max(0.0, light_ * kTwoPi * reach_ * reach_ * integral);
}

double HigherOrders::within(double f) const {
  if (octaves_.empty()) return 0;
  return light_ * std::clamp(octave(f).disc(kTwoPi * f * reach_).share, 0.0, 1.0);
}

}  // namespace aberfit::internal
