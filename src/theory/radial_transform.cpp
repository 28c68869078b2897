#include "radial_transform.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/bessel.h"

namespace aberfit::internal {
namespace {

using std::numbers::pi;

constexpr double kMoments = 0.25;  // v s below which four terms of J1 have an error of 1e-13
constexpr double kDirect =
    8;  // v (b - a) up to which 24 nodes carry T of degree 23 times J1: J_24(4) = 1e-17
constexpr double kHankelFrom = 30;  // see hankel_amplitudes
constexpr double kFilonCosine = 8;  // the same for cosines

bool is_direct(const TransferPanel& panel, double v) { return v * (panel.b - panel.a) <= kDirect; }

// This method is for panels on which the argument of J1 changes much.
void add_disc(const TransferPanel& panel, double v, RadialTransform::Disc* sum) {
  const PanelArray s = panel.nodes();
  if (is_direct(panel, v)) {
    const PanelArray weighted = 0.5 * (panel.b - panel.a) * panel_rule().weight * panel.value;
    const BesselSums sums = bessel_sums(v, s.data(), weighted.data(), kPanelNodes);
    sum->share += v * sums.first;
    sum->derivative += v * sums.zeroth;
  } else if (v * panel.a >= kHankelFrom) {
    const auto weights = oscillatory_weights(panel.a, panel.b, v);
    const PanelArray z = v * s;
    PanelArray p0, q0, p1, q1;
    hankel_amplitudes(z.data(), kPanelNodes, p0.data(), q0.data(), p1.data(), q1.data());
    const PanelArray real = v * weights.real() * panel.value, imaginary = v * weights.imag() * panel.value;
    const std::complex<double> first((real * p1 - imaginary * q1).sum(), (real * q1 + imaginary * p1).sum());
    const std::complex<double> zeroth((s * (real * p0 - imaginary * q0)).sum(),
                                      (s * (real * q0 + imaginary * p0)).sum());
    sum->share += (first * std::polar(1.0, -0.75 * pi)).real();
    sum->derivative += (zeroth * std::polar(1.0, -0.25 * pi)).real();
  } else {
    add_disc(lower_half(panel), v, sum);
    add_disc(upper_half(panel), v, sum);
  }
}

}  // namespace

RadialTransform::RadialTransform(std::vector<TransferPanel> panels) : panels_(std::move(panels)) {
  std::array<double, 4> sum{};
  for (const TransferPanel& panel : panels_) {
    const PanelArray s = panel.nodes();
    PanelArray term = 0.5 * (panel.b - panel.a) * panel_rule().weight * panel.value;
    s_.insert(s_.end(), s.data(), s.data() + kPanelNodes);
    weighted_.insert(weighted_.end(), term.data(), term.data() + kPanelNodes);
    term *= s;
    for (double& moment : sum) {
      moment += term.sum();
      term *= s.square();
    }
    moments_.push_back(sum);
  }
}

RadialTransform::Disc RadialTransform::disc(double v) const {
  if (!std::isfinite(v)) return {kNaN, kNaN};  // halving would not end
  std::size_t next = 0;
  while (next < panels_.size() && v * panels_[next].b < kMoments) ++next;
  Disc sum;
  if (next > 0) {
    const std::array<double, 4>& m = moments_[next - 1];
    const double q = 0.25 * v * v;  // v J1(v s) = 2 q s (1 - q s^2/2 (1 - q s^2/6 (1 - q s^2/12)))
    sum.share = 2 * q * (m[0] - q / 2 * (m[1] - q / 6 * (m[2] - q / 12 * m[3])));
    sum.derivative = v * (m[0] - q * (m[1] - q / 4 * (m[2] - q / 9 * m[3])));
  }
  while (next < panels_.size()) {
    std::size_t end = next;
    while (end < panels_.size() && is_direct(panels_[end], v)) ++end;
    if (end > next) {
      const std::size_t at = next * kPanelNodes;
      const BesselSums sums = bessel_sums(v, &s_[at], &weighted_[at], int((end - next) * kPanelNodes));
      sum.share += v * sums.first;
      sum.derivative += v * sums.zeroth;
    }
    for (next = end; next < panels_.size() && !is_direct(panels_[next], v); ++next)
      add_disc(panels_[next], v, &sum);
  }
  return sum;
}

double RadialTransform::cosine(double w) const {
  double sum = 0;
  for (const TransferPanel& panel : panels_) {
    if (w * (panel.b - panel.a) <= kFilonCosine)
      sum +=
          0.5 * (panel.b - panel.a) * (panel_rule().weight * panel.value * (w * panel.nodes()).cos()).sum();
    else
      sum += (oscillatory_weights(panel.a, panel.b, w).real() * panel.value).sum();
  }
  return sum;
}

double RadialTransform::cosine_slope(double w) const {
  double sum = 0;
  for (const TransferPanel& panel : panels_) {
    const PanelArray s = panel.nodes();
    if (w * (panel.b - panel.a) <= kFilonCosine)
      sum -= 0.5 * (panel.b - panel.a) * (panel_rule().weight * panel.value * s * (w * s).sin()).sum();
    else
      sum -= (oscillatory_weights(panel.a, panel.b, w).imag() * panel.value * s).sum();
  }
  return sum;
}

double RadialTransform::first_moment() const { return moments_.empty() ? 0 : moments_.back()[0]; }

PanelArray RadialTransform::on(double a, double b) const {
  const double middle = 0.5 * (a + b);
  const auto panel = std::lower_bound(panels_.begin(), panels_.end(), middle,
                                      [](const TransferPanel& one, double s) { return one.b < s; });
  if (panel == panels_.end() || panel->a > middle) return PanelArray::Zero();
  return restricted(*panel, a, b);
}

// A span of zero width has all of its nodes at s.
double RadialTransform::at(double s) const { return on(s, s)[0]; }

}  // namespace aberfit::internal
