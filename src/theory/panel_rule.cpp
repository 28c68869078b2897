#include "panel_rule.h"

#include "aberfit/core/quadrature.h"

namespace aberfit::internal {

const PanelRule& panel_rule() {
  static const PanelRule rule = [] {
    PanelRule r;
    const Quadrature gauss = gauss_legendre(kPanelNodes, -1.0, 1.0);
    r.t = gauss.nodes;
    r.weight = gauss.weights;
    const auto legendre = [](const PanelArray& t) {  // (l, node)
      PanelRule::Matrix p;
      p.row(0).setOnes();
      p.row(1) = t.transpose();
      for (int l = 1; l + 1 < kPanelNodes; ++l)
        p.row(l + 1) =
            ((2 * l + 1) * t.transpose() * p.row(l).array() - l * p.row(l - 1).array()) / (l + 1.0);
      return p;
    };
    PanelRule::Matrix coefficients = legendre(r.t);  // (l, node): Legendre coefficients from values
    for (int l = 0; l < kPanelNodes; ++l)
      coefficients.row(l) = (l + 0.5) * coefficients.row(l).array() * r.weight.transpose();
    r.last = coefficients.row(kPanelNodes - 1).transpose();
    r.last_but_one = coefficients.row(kPanelNodes - 2).transpose();
    r.legendre = coefficients;
    r.left = legendre(0.5 * r.t - 0.5).transpose() * coefficients;
    r.right = legendre(0.5 * r.t + 0.5).transpose() * coefficients;
    return r;
  }();
  return rule;
}

double unresolved(const TransferPanel& panel) {
  const PanelRule& rule = panel_rule();
  return std::abs((panel.value * rule.last).sum()) + std::abs((panel.value * rule.last_but_one).sum());
}

TransferPanel lower_half(const TransferPanel& panel) {
  return {panel.a, 0.5 * (panel.a + panel.b), (panel_rule().left * panel.value.matrix()).array()};
}

TransferPanel upper_half(const TransferPanel& panel) {
  return {0.5 * (panel.a + panel.b), panel.b, (panel_rule().right * panel.value.matrix()).array()};
}

PanelArray restricted(const TransferPanel& panel, double a, double b) {
  if (a == panel.a && b == panel.b) return panel.value;
  const PanelRule& rule = panel_rule();
  const double width = panel.b - panel.a;
  const PanelArray c = (rule.legendre * panel.value.matrix()).array();
  const PanelArray t = (a + b - panel.a - panel.b) / width + (b - a) / width * rule.t;
  PanelArray above = PanelArray::Zero(), here = PanelArray::Zero();  // Clenshaw
  for (int l = kPanelNodes - 1; l > 0; --l) {
    const PanelArray below = c[l] + (2 * l + 1) / (l + 1.0) * t * here - (l + 1) / (l + 2.0) * above;
    above = here;
    here = below;
  }
  return c[0] + t * here - 0.5 * above;
}

}  // namespace aberfit::internal
