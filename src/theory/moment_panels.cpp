#include "moment_panels.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/core/quadrature.h"

namespace aberfit::internal {
namespace {

constexpr std::size_t kMostMomentPanels = 3000;
constexpr double kNarrowestMoments = 1e-12;  // in units of the cutoff

}  // namespace

MomentBasis::MomentBasis(int count) : order(count), lagrange(count, count) {
  using std::numbers::pi;
  for (int i = 0; i < order; ++i) nodes.push_back(0.5 - 0.5 * std::cos(pi * (i + 0.5) / order));
  for (int i = 0; i < order; ++i)
    for (int p = 0; p < order; ++p)
      lagrange(i, p) = (p == 0 ? 1.0 : 2.0) / order * std::cos(p * (pi - pi * (i + 0.5) / order));
}

Eigen::ArrayXd MomentBasis::at_nodes(const Eigen::MatrixXd& by_chebyshev) const {
  const Eigen::MatrixXd all = lagrange * by_chebyshev * lagrange.transpose();
  return all.transpose().reshaped().array();
}

MomentPanel::Values MomentPanel::restricted(double from, double to) const {
  if (from == a && to == b) return value;
  const PanelArray t = (from + to - a - b) / (b - a) + (to - from) / (b - a) * panel_rule().t;
  return (legendre_polynomials(t, kPanelNodes).matrix() * legendre().matrix()).array();
}

MomentPanel::Values MomentPanel::legendre() const { return (panel_rule().legendre * value.matrix()).array(); }

Eigen::ArrayXd MomentPanel::at(double s, const Values& c) const {
  const double t = (2 * s - a - b) / (b - a);
  double before = 1, last = t;
  Eigen::ArrayXd sum = c.row(0).transpose() + t * c.row(1).transpose();
  for (int l = 1; l + 1 < kPanelNodes; ++l) {
    const double next = ((2 * l + 1) * t * last - l * before) / (l + 1);
    before = last;
    last = next;
    sum += next * c.row(l + 1).transpose();
  }
  return sum;
}

MomentPanels moment_panels(const std::function<Eigen::ArrayXd(double)>& moments,
                           const std::vector<double>& breakpoints, double end, double accuracy) {
  std::vector<std::pair<double, double>> pending;
  double from = 0;
  for (const double place : breakpoints) {
    const double to = std::min(place, end);
    if (to > from) pending.emplace_back(from, to);
    from = std::max(from, to);
  }
  const PanelRule& rule = panel_rule();
  MomentPanels result;
  while (!pending.empty()) {
    const auto [a, b] = pending.back();
    pending.pop_back();
    MomentPanel panel{a, b, {}};
    const PanelArray nodes = 0.5 * (a + b) + 0.5 * (b - a) * rule.t;
    for (int j = 0; j < kPanelNodes; ++j) {
      const Eigen::ArrayXd row = moments(nodes[j]);
      if (j == 0) panel.value.resize(kPanelNodes, row.size());
      panel.value.row(j) = row.transpose();
    }
    if (!panel.value.isFinite().all())
      throw ComputationError("the transfer function of this mirror is not finite in this plane");
    double missed = 0;
    for (Eigen::Index k = 0; k < panel.value.cols(); ++k)
      missed = std::max(missed, std::abs((panel.value.col(k) * rule.last).sum()) +
                                    std::abs((panel.value.col(k) * rule.last_but_one).sum()));
    if (missed * std::sqrt((b - a) / b) <= accuracy || b - a < kNarrowestMoments) {
      result.push_back(std::move(panel));
      continue;
    }
    if (result.size() + pending.size() >= kMostMomentPanels)
      throw ComputationError("the mean spot of this pupil is not resolved by 3000 panels of its transfer");
    const double middle = 0.5 * (a + b);
    pending.insert(pending.end(), {{a, middle}, {middle, b}});
  }
  std::sort(result.begin(), result.end(),
            [](const MomentPanel& one, const MomentPanel& two) { return one.a < two.a; });
  return result;
}

}  // namespace aberfit::internal
