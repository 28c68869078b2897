#include "radial_transform.h"

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <numbers>

namespace aberfit {
namespace {

using std::numbers::pi;

constexpr double kMoments = 0.25;  // v s below which four terms of J1 err by 1e-13
constexpr double kDirect =
    8;  // v (b - a) up to which 24 nodes carry T of degree 23 times J1: J_24(4) = 1e-17
constexpr double kHankelFrom = 30;  // see hankel_amplitudes
constexpr double kFilonCosine = 8;  // the same for cosines

void add_disc(const TransferPanel& panel, double v, RadialTransform::Disc* sum) {
  const double turn = v * (panel.b - panel.a);
  if (turn <= kDirect) {
    const PanelRule& rule = panel_rule();
    const PanelArray s = panel.nodes(), weighted = 0.5 * (panel.b - panel.a) * v * rule.weight * panel.value;
    for (int j = 0; j < kPanelNodes; ++j) {
      sum->share += weighted[j] * boost::math::cyl_bessel_j(1, v * s[j]);
      sum->derivative += weighted[j] * s[j] * boost::math::cyl_bessel_j(0, v * s[j]);
    }
  } else if (v * panel.a >= kHankelFrom) {
    const auto weights = oscillatory_weights(panel.a, panel.b, v);
    const PanelArray s = panel.nodes();
    std::complex<double> first = 0, zeroth = 0;
    for (int j = 0; j < kPanelNodes; ++j) {
      const double z = v * s[j];
      const HankelAmplitudes h = hankel_amplitudes(z);
      const std::complex<double> weighted = weights[j] * (v * panel.value[j] * std::sqrt(2 / (pi * z)));
      first += weighted * h.h1;
      zeroth += weighted * h.h0 * s[j];
    }
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
    PanelArray term = 0.5 * (panel.b - panel.a) * panel_rule().weight * panel.value * s;
    for (double& moment : sum) {
      moment += term.sum();
      term *= s.square();
    }
    moments_.push_back(sum);
  }
}

RadialTransform::Disc RadialTransform::disc(double v) const {
  std::size_t next = 0;
  while (next < panels_.size() && v * panels_[next].b < kMoments) ++next;
  Disc sum;
  if (next > 0) {
    const std::array<double, 4>& m = moments_[next - 1];
    const double q = 0.25 * v * v;  // v J1(v s) = 2 q s (1 - q s^2/2 (1 - q s^2/6 (1 - q s^2/12)))
    sum.share = 2 * q * (m[0] - q / 2 * (m[1] - q / 6 * (m[2] - q / 12 * m[3])));
    sum.derivative = v * (m[0] - q * (m[1] - q / 4 * (m[2] - q / 9 * m[3])));
  }
  for (; next < panels_.size(); ++next) add_disc(panels_[next], v, &sum);
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

double RadialTransform::first_moment() const { return moments_.empty() ? 0 : moments_.back()[0]; }

}  // namespace aberfit
