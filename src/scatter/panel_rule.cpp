#include "panel_rule.h"

#include "aberfit/core/quadrature.h"

namespace aberfit {

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

}  // namespace aberfit
