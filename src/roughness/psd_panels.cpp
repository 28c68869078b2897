#include <algorithm>
#include <cassert>
#include <cmath>

#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/psd_integrals.h"

namespace aberfit {
namespace {

constexpr double kResolved = 1e-14;
constexpr int kMaxHalvings = 10;  // exp(-700 t^2) on [1, 2], the steepest that does not underflow, needs 5

// Constant, computed at first use.
const LegendreRule& reference_panel() {
  static const LegendreRule rule = legendre_rule(kPanelNodes);
  return rule;
}

PsdPanel panel_on(const RadialPsd& psd, double a, double b) {
  const LegendreRule& reference = reference_panel();
  PsdPanel panel{
      a, b, 0.5 * (a + b) + 0.5 * (b - a) * reference.nodes, 0.5 * (b - a) * reference.weights, {}};
  for (int j = 0; j < kPanelNodes; ++j) panel.psd[j] = psd(panel.f[j]);
  return panel;
}

// The last two Legendre coefficients estimate the error of the polynomial. The lower limit is the rounding of
// S itself: exp(-z) has a relative error z eps, which halving does not remove.
bool resolved(const PsdPanel& panel) {
  const LegendreRule& reference = reference_panel();
  const double top = panel.psd.abs().maxCoeff();
  if (top < 1e-290) return true;
  double missed = 0;
  for (int l = kPanelNodes - 2; l < kPanelNodes; ++l)
    missed += (l + 0.5) * std::abs((reference.weights * panel.psd * reference.polynomials.col(l)).sum());
  return missed <= (kResolved + 4e-16 * std::abs(std::log(top))) * (2 * kPanelNodes) * top;
}

void append_resolved(const RadialPsd& psd, double a, double b, int halvings, std::vector<PsdPanel>* panels) {
  const PsdPanel panel = panel_on(psd, a, b);
  const double middle = 0.5 * (a + b);
  // Values that are not finite stay so in every half.
  if (halvings < kMaxHalvings && a < middle && middle < b && panel.psd.isFinite().all() && !resolved(panel)) {
    append_resolved(psd, a, middle, halvings + 1, panels);
    append_resolved(psd, middle, b, halvings + 1, panels);
  } else if ((panel.psd != 0).any()) {
    panels->push_back(panel);
  }
}

// Spherical Bessel functions j_0 .. j_{kPanelNodes-1}: upward if that is stable, else downward (Miller).
PanelArray spherical_bessel(double x) {
  PanelArray j = PanelArray::Zero();
  if (x < 1e-8) {  // higher powers are below rounding
    j[0] = 1;
    j[1] = x / 3;
    return j;
  }
  const double j0 = std::sin(x) / x, j1 = (j0 - std::cos(x)) / x;
  if (x > kPanelNodes) {
    j[0] = j0;
    j[1] = j1;
    for (int l = 1; l + 1 < kPanelNodes; ++l) j[l + 1] = (2 * l + 1) / x * j[l] - j[l - 1];
    return j;
  }
  double above = 0, here = 1e-280;
  const double inverse = 1 / x;
  for (int l = kPanelNodes + 40; l >= 0; --l) {
    if (l < kPanelNodes) j[l] = here;
    const double below = (2 * l + 1) * inverse * here - above;
    above = here;
    here = below;
    if (std::abs(here) > 1e250) {
      above *= 1e-250;
      here *= 1e-250;
      j *= 1e-250;
    }
  }
  j *= std::abs(j0) > std::abs(j1) || x < 1 ? j0 / j[0] : j1 / j[1];
  return j;
}

}  // namespace

std::vector<PsdPanel> resolved_panels(const RadialPsd& psd, double a, double b, double max_ratio,
                                      double max_width) {
  std::vector<PsdPanel> panels;
  a = std::max(a, psd.f_min());
  b = std::min(b, psd.f_max());
  if (!(a < b)) return panels;
  assert(a > 0 && std::isfinite(b));
  const std::vector<double>& bends = psd.breakpoints();
  std::vector<double> edges = {a};
  for (auto bend = std::upper_bound(bends.begin(), bends.end(), a); bend != bends.end() && *bend < b; ++bend)
    edges.push_back(*bend);
  edges.push_back(b);
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const int octaves =
        std::max(1, int(std::ceil(std::log(edges[i + 1] / edges[i]) / std::log(max_ratio) - 1e-9)));
    double lower = edges[i];
    for (int k = 1; k <= octaves; ++k) {
      const double upper =
          k == octaves ? edges[i + 1] : edges[i] * std::pow(edges[i + 1] / edges[i], double(k) / octaves);
      const int pieces = std::max(1, int(std::ceil((upper - lower) / max_width - 1e-9)));
      for (int p = 0; p < pieces; ++p)
        append_resolved(psd, lower + (upper - lower) * p / pieces,
                        p + 1 == pieces ? upper : lower + (upper - lower) * (p + 1) / pieces, 0, &panels);
      lower = upper;
    }
  }
  return panels;
}

Eigen::Array<std::complex<double>, kPanelNodes, 1> oscillatory_weights(double a, double b, double omega) {
  const LegendreRule& reference = reference_panel();
  const double half = 0.5 * (b - a), centre = 0.5 * (a + b);
  const PanelArray j = spherical_bessel(std::abs(omega) * half);
  // Real and imaginary part of sum (2l+1) i^l j_l P_l are even and odd over the panel; half of it suffices.
  constexpr int kHalf = kPanelNodes / 2;
  Eigen::Array<double, kHalf, 1> half_even = Eigen::Array<double, kHalf, 1>::Zero(), half_odd = half_even;
  for (int l = 0; l < kPanelNodes; l += 2) {
    const double sign = l % 4 == 0 ? 1 : -1;
    half_even += sign * (2 * l + 1) * j[l] * reference.polynomials.col(l).head<kHalf>();
    half_odd += sign * (2 * l + 3) * j[l + 1] * reference.polynomials.col(l + 1).head<kHalf>();
  }
  if (omega < 0) half_odd = -half_odd;
  PanelArray even, odd;
  even << half_even, half_even.reverse();
  odd << half_odd, -half_odd.reverse();
  const std::complex<double> phase = std::polar(half, omega * centre);
  Eigen::Array<std::complex<double>, kPanelNodes, 1> weights;
  for (int i = 0; i < kPanelNodes; ++i)
    weights[i] = phase * reference.weights[i] * std::complex<double>(even[i], odd[i]);
  return weights;
}

HankelAmplitudes hankel_amplitudes(double x) {
  assert(x >= 30);
  const auto series = [x](double four_nu_squared) {
    std::complex<double> sum = 0, term = 1;
    for (int k = 1; std::abs(term) > 1e-17; ++k) {
      sum += term;
      const double odd = 2 * k - 1;
      term *= std::complex<double>(0, (four_nu_squared - odd * odd) / (8 * k * x));
    }
    return sum;
  };
  return {series(0), series(4)};
}

PowerLawLimits power_law_limits(const RadialPsd& psd) {
  const std::vector<double>& bends = psd.breakpoints();
  PowerLawLimits limits{psd.f_min(), psd.f_max()};
  if (psd.f_min() == 0) limits.low = bends.empty() ? 1.0 : 1e-9 * bends.front();
  if (std::isinf(psd.f_max())) limits.high = bends.empty() ? 1.0 : 1e9 * bends.back();
  return limits;
}

}  // namespace aberfit
