#include "frequency_panels.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/quadrature.h"

namespace aberfit::internal {
namespace {

constexpr double kWidestPart = 0.05;  // in units of the frequency
constexpr double kSameEdge = 0.02;    // in units of the frequency: closer breakpoints have a common panel

}  // namespace

FrequencyPanels::FrequencyPanels(const RadialPsd& psd, double low, double high, double width) {
  const Quadrature rule = gauss_legendre(kNodes, -1, 1);
  nodes_ = rule.nodes;
  weights_ = 0.5 * rule.weights;
  std::vector<double> stops{low};
  for (const double f : psd.breakpoints())
    if (f > stops.back() * (1 + kSameEdge) && f * (1 + kSameEdge) < high) stops.push_back(f);
  stops.push_back(high);
  edges_.push_back(low);
  for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
    // Equal steps in v, dv = df/max(width, part f), so that the edges move smoothly with those of the band.
    const double knee = width / kWidestPart;
    const auto count = [&](double f) { return f < knee ? f / knee : 1 + std::log(f / knee); };
    const auto frequency = [&](double v) { return v < 1 ? v * knee : knee * std::exp(v - 1); };
    const double a = count(stops[i]), b = count(stops[i + 1]);
    const int pieces = std::max(1, int(std::ceil((b - a) / kWidestPart)));
    for (int k = 1; k < pieces; ++k) edges_.push_back(frequency(a + (b - a) * k / pieces));
    edges_.push_back(stops[i + 1]);
  }
  frequency_.resize(panels() * kNodes);
  for (Eigen::Index p = 0; p < panels(); ++p)
    frequency_.segment<kNodes>(p * kNodes) = edges_[std::size_t(p)] + this->width(p) * 0.5 * (1 + nodes_);
}

FrequencyPanels::Place FrequencyPanels::place(double f) const {
  const auto above = std::upper_bound(edges_.begin() + 1, edges_.end() - 1, f);
  Place result;
  result.panel = above - edges_.begin() - 1;
  const double a = edges_[std::size_t(result.panel)], half = 0.5 * width(result.panel);
  const double t = std::clamp((f - a) / half - 1, -1.0, 1.0);
  // Lagrange polynomials in Legendre's: l_j = sum_n (2n+1)/2 w_j P_n(t_j) P_n, and int_t^1 P_n = (P_{n-1}(t)
  // - P_{n+1}(t))/(2n+1). weights_ are w_j/2.
  Eigen::Array<double, kNodes, 1> before = Eigen::Array<double, kNodes, 1>::Ones(), here = nodes_;
  result.weight = weights_ * (1 - t);
  double p_before = 1, p_here = t;
  for (int n = 1; n < kNodes; ++n) {
    const double p_after = ((2 * n + 1) * t * p_here - n * p_before) / (n + 1);
    result.weight += weights_ * here * (p_before - p_after);
    const Eigen::Array<double, kNodes, 1> after = ((2 * n + 1) * nodes_ * here - n * before) / (n + 1);
    before = here;
    here = after;
    p_before = p_here;
    p_here = p_after;
  }
  result.weight *= half;
  return result;
}

TailIntegrals::TailIntegrals(const FrequencyPanels& panels, Eigen::ArrayXXd integrand)
    : integrand_(integrand.transpose()) {
  constexpr int kNodes = FrequencyPanels::kNodes;
  above_ = Eigen::ArrayXXd::Zero(integrand_.rows(), panels.panels() + 1);
  for (Eigen::Index p = panels.panels() - 1; p >= 0; --p)
    above_.col(p) = above_.col(p + 1) +
                    (integrand_.middleCols<kNodes>(p * kNodes).matrix() * panels.weights().matrix()).array() *
                        panels.width(p);
}

Eigen::ArrayXd TailIntegrals::from(const FrequencyPanels::Place& place) const {
  constexpr int kNodes = FrequencyPanels::kNodes;
  return (above_.col(place.panel + 1) +
          (integrand_.middleCols<kNodes>(place.panel * kNodes).matrix() * place.weight.matrix()).array())
      .max(0.0);
}

}  // namespace aberfit::internal
