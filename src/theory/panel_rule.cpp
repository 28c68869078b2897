#include "panel_rule.h"

#include <algorithm>

#include "aberfit/core/quadrature.h"

namespace aberfit::internal {

const PanelRule& panel_rule() {
  static const PanelRule rule = [] {
    PanelRule r;
    const LegendreRule gauss = legendre_rule(kPanelNodes);
    r.t = gauss.nodes;
    r.weight = gauss.weights;
    for (int l = 0; l < kPanelNodes; ++l)
      r.legendre.row(l) = ((l + 0.5) * gauss.polynomials.col(l) * gauss.weights).matrix().transpose();
    r.last = r.legendre.row(kPanelNodes - 1).transpose();
    r.last_but_one = r.legendre.row(kPanelNodes - 2).transpose();
    const auto at = [&](const PanelArray& t) -> PanelRule::Matrix {
      return legendre_polynomials(t, kPanelNodes).matrix() * r.legendre;
    };
    r.left = at(0.5 * r.t - 0.5);
    r.right = at(0.5 * r.t + 0.5);
    return r;
  }();
  return rule;
}

double refine(std::vector<TransferPanel> pending, std::size_t most,
              const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& values,
              const std::function<double(TransferPanel*)>& missing, std::vector<TransferPanel>* panels) {
  double missed = 0;
  while (!pending.empty()) {
    Eigen::ArrayXd x(Eigen::Index(pending.size()) * kPanelNodes);
    for (std::size_t i = 0; i < pending.size(); ++i)
      x.segment<kPanelNodes>(Eigen::Index(i) * kPanelNodes) = pending[i].nodes();
    const Eigen::ArrayXd value = values(x);
    std::vector<TransferPanel> halves;
    for (std::size_t i = 0; i < pending.size(); ++i) {
      TransferPanel& panel = pending[i];
      panel.value = value.segment<kPanelNodes>(Eigen::Index(i) * kPanelNodes);
      const double lack = missing(&panel);
      if (lack > 0 && panels->size() + pending.size() + halves.size() < most) {
        const double middle = 0.5 * (panel.a + panel.b);
        halves.push_back({panel.a, middle});
        halves.push_back({middle, panel.b});
      } else {
        missed = std::max(missed, lack);
        panels->push_back(panel);
      }
    }
    pending = std::move(halves);
  }
  std::sort(panels->begin(), panels->end(),
            [](const TransferPanel& one, const TransferPanel& two) { return one.a < two.a; });
  return missed;
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

void PanelFunction::set_coefficients() {
  for (const TransferPanel& panel : panels)
    legendre.push_back((panel_rule().legendre * panel.value.matrix()).array());
}

std::size_t PanelFunction::panel_at(double x) const {
  const auto panel = std::lower_bound(panels.begin(), panels.end(), x,
                                      [](const TransferPanel& one, double place) { return one.b < place; });
  return panel == panels.end() ? panels.size() - 1 : std::size_t(panel - panels.begin());
}

double PanelFunction::at(double x, std::size_t panel) const {
  const TransferPanel& here = panels[panel];
  const PanelArray& c = legendre[panel];
  const double t = std::clamp((2 * x - here.a - here.b) / (here.b - here.a), -1.0, 1.0);
  double sum = c[0] + c[1] * t, before = 1, last = t;
  for (int l = 1; l + 1 < kPanelNodes; ++l) {
    const double next = ((2 * l + 1) * t * last - l * before) / (l + 1);
    before = last;
    last = next;
    sum += c[l + 1] * next;
  }
  return sum;
}

PanelArray PanelFunction::at(const PanelArray& x, std::size_t panel) const {
  const TransferPanel& here = panels[panel];
  const PanelArray& c = legendre[panel];
  const PanelArray t = (2 * x - here.a - here.b) / (here.b - here.a);
  PanelArray before = PanelArray::Ones(), last = t;
  PanelArray result = c[0] + c[1] * t;
  for (int l = 1; l + 1 < kPanelNodes; ++l) {
    const double back = l / (l + 1.0);
    const PanelArray next = (1 + back) * t * last - back * before;
    before = last;
    last = next;
    result += c[l + 1] * next;
  }
  return result;
}

}  // namespace aberfit::internal
