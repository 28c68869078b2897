#include "structure_quadrature.h"

#include <numbers>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/bessel.h"

namespace aberfit::internal {
namespace {

const LegendreRule& unit_rule() {
  static const LegendreRule rule = legendre_rule(kPanelNodes);
  return rule;
}
const LegendreRule& long_rule() {
  static const LegendreRule rule = legendre_rule(2 * kPanelNodes);
  return rule;
}

// A rule for S times J0 over `turn` radians on one panel; null where Filon's rule costs less. n nodes are
// exact to degree 2 n - 1, and the Legendre coefficients of S fall to 1e-14 by degree 23. The largest product
// of such a coefficient with its J_(2n-l)(turn/2) is below 4e-17.
const LegendreRule* rule_for(double turn) {
  if (turn <= 24) return &unit_rule();
  if (turn <= 90) return &long_rule();
  static const LegendreRule wide = legendre_rule(96), widest = legendre_rule(192);
  if (turn <= 240) return &wide;
  return turn <= 560 ? &widest : nullptr;
}

// 24 nodes resolve J0 over 10 rad: J_24(5) = 4e-15. 48 nodes resolve it over 36 rad: J_48(18) = 1e-16.
constexpr double kTurnOfMerged = 10, kTurnOfLong = 36;
constexpr std::size_t kWavesOfMerged = 40;  // their cost is that of 24 values of J0
}  // namespace

StructureQuadrature::StructureQuadrature(const RadialPsd& psd, std::vector<PowerStretch> stretches,
                                         double r_min, double r_max, const LogSlope* slope)
    : shared_(shared_panels(psd, r_min, r_max)), stretches_(std::move(stretches)), r_max_(r_max) {
  if (slope)
    for (PsdPanel& panel : shared_.panels)
      panel.psd *= panel.f.unaryExpr([&](double f) { return (*slope)(f); });
  for (const PsdPanel& panel : shared_.panels) {
    std::size_t s = 0;
    if (!stretch_.empty() && stretch_.back() < stretches_.size()) s = stretch_.back();
    while (s < stretches_.size() && panel.b > stretches_[s].f_max()) ++s;
    stretch_.push_back(s < stretches_.size() && panel.a >= stretches_[s].f_min() ? s : stretches_.size());
  }
  if (slope)
    psd_ = [psd, q = *slope](double f) { return psd(f) * q(f); };
  else
    psd_ = [psd](double f) { return psd(f); };
  const auto moment = [&](double power, double a, double b) {
    return slope ? slope_moment(psd, *slope, power, a, b) : radial_moment(psd, power, a, b);
  };
  // Below the panels we use the series of 1 - J0. It is negligible if the height variance is finite, but
  // large if S falls almost as fast as f^-4.
  if (psd.f_min() == 0)
    for (std::size_t m = 1; m < low_.size(); ++m)
      low_[m] = std::pow(kPi, 2.0 * double(m)) * moment(2.0 * double(m), 0, shared_.low);
  Powers sum = low_;
  for (const PsdPanel& panel : shared_.panels) {
    PanelArray term = 2 * kPi * panel.weight * panel.psd * panel.f;
    mass_.push_back(term.sum());
    for (double& power : sum) {
      power += term.sum();
      term *= (kPi * panel.f).square();
    }
    below_.push_back(sum);
  }
  if (std::isinf(psd.f_max()) && !shared_.panels.empty())
    beyond_ = moment(0, shared_.panels.back().b, kInfinity);  // J0 averages out there
}

double StructureQuadrature::operator()(double r) {
  const std::size_t octave = std::size_t(std::max(0.0, std::floor(std::log2(r_max_ / r))));
  if (octave >= plans_.size()) plans_.resize(octave + 1);
  if (!plans_[octave]) plans_[octave] = plan(2 * kPi * std::ldexp(r_max_, -int(octave)));
  const Plan& now = *plans_[octave];
  const double k = 2 * kPi * r;
  double sum = beyond_;
  // Four terms of 1 - J0; the next is 1e-12 of the first.
  const Powers& p = now.first > 0 ? below_[now.first - 1] : low_;
  const double q = r * r;
  sum += q * (p[1] - q / 4 * (p[2] - q / 9 * (p[3] - q / 16 * p[4])));
  sum += one_minus_j0_sum(k, now.f.data(), now.weight.data(), int(now.f.size()));
  for (const std::size_t i : now.wide) sum += far(i, k);
  return sum + (now.wave_mass - now.waves(r));
}

void StructureQuadrature::Plan::add(double node, double node_weight) {
  if (!waves.carries(node)) {
    f.push_back(node);
    weight.push_back(node_weight);
    return;
  }
  wave_mass += node_weight;
  waves.add_node(node, node_weight);
}

// The plan for wave numbers in [k/2, k].
StructureQuadrature::Plan StructureQuadrature::plan(double k) const {
  const std::vector<PsdPanel>& panels = shared_.panels;
  Plan result;
  result.waves = PowerWaves(0.5 * k);
  while (result.first < panels.size() && k * panels[result.first].b < 0.2) ++result.first;
  std::size_t i = result.first;
  while (i < panels.size()) {
    const double a = panels[i].a;
    const double turn = k * a >= kTurnOfLong ? kTurnOfLong : kTurnOfMerged;
    std::size_t end = i + 1;
    while (end < panels.size() && k * (panels[end].b - a) <= turn && panels[end].b <= 2 * a &&
           panels[end].a == panels[end - 1].b)
      ++end;
    const std::size_t s = stretch_[i];
    const std::size_t waves = stretch_[end - 1] - s;  // number of waves instead of the merged panels
    if (s < stretches_.size() && 0.5 * k * a >= stretches_[s].smallest() && waves <= kWavesOfMerged) {
      for (; i < panels.size() && stretch_[i] == s; ++i) {
        result.wave_mass += mass_[i];
        end = i + 1;
      }
      const double b = panels[end - 1].b;
      result.waves.add(stretches_[s], a, psd_(a), b, psd_(b));
      continue;
    }
    if (end - i > 1) {
      append_merged(i, end, k * (panels[end - 1].b - a) > kTurnOfMerged ? long_rule() : unit_rule(), &result);
    } else if (const LegendreRule* rule = rule_for(k * (panels[i].b - a))) {
      append_panel(panels[i], *rule, &result);
    } else {
      result.wide.push_back(i);
    }
    i = end;
  }
  result.waves.arrange(result.wave_mass);
  return result;
}

// Appends the nodes of the rule, with weights that integrate S times polynomials over panels [i, end).
void StructureQuadrature::append_merged(std::size_t i, std::size_t end, const LegendreRule& rule,
                                        Plan* plan) const {
  const double a = shared_.panels[i].a, b = shared_.panels[end - 1].b;
  const int n = int(rule.nodes.size());
  Eigen::ArrayXd moment = Eigen::ArrayXd::Zero(n);  // moments of Legendre polynomials
  for (std::size_t p = i; p < end; ++p) {
    const PsdPanel& panel = shared_.panels[p];
    const PanelArray t = (2 * panel.f - (a + b)) / (b - a);
    const PanelArray weight = 2 * kPi * panel.weight * panel.psd * panel.f;
    PanelArray before = PanelArray::Zero(), here = PanelArray::Ones();
    for (int l = 0; l < n; ++l) {
      moment[l] += (l + 0.5) * (weight * here).sum();
      const double back = l / (l + 1.0);
      const PanelArray next = (1 + back) * t * here - back * before;
      before = here;
      here = next;
    }
  }
  const Eigen::ArrayXd weights = rule.weights * (rule.polynomials.matrix() * moment.matrix()).array();
  for (int j = 0; j < n; ++j) plan->add(0.5 * (a + b) + 0.5 * (b - a) * rule.nodes[j], weights[j]);
}

void StructureQuadrature::append_panel(const PsdPanel& panel, const LegendreRule& rule, Plan* plan) const {
  const bool own = rule.nodes.size() == kPanelNodes;
  for (Eigen::Index j = 0; j < rule.nodes.size(); ++j) {
    const double f = own ? panel.f[j] : 0.5 * (panel.a + panel.b) + 0.5 * (panel.b - panel.a) * rule.nodes[j];
    const double psd = own ? panel.psd[j] : psd_(f);
    plan->add(f, kPi * (panel.b - panel.a) * rule.weights[j] * psd * f);
  }
}

double StructureQuadrature::far(std::size_t i, double k) const {
  const PsdPanel& panel = shared_.panels[i];
  const auto weights = oscillatory_weights(panel.a, panel.b, k);
  const PanelArray x = k * panel.f, shape = panel.psd * panel.f;
  PanelArray p0, q0, p1, q1;
  hankel_amplitudes(x.data(), kPanelNodes, p0.data(), q0.data(), p1.data(), q1.data());
  const double real = (shape * (weights.real() * p0 - weights.imag() * q0)).sum(),
               imaginary = (shape * (weights.real() * q0 + weights.imag() * p0)).sum();
  return mass_[i] - 2 * kPi * (real + imaginary) / std::numbers::sqrt2;
}

}  // namespace aberfit::internal
