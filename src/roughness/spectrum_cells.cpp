#include "aberfit/roughness/spectrum_cells.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/quadrature.h"

namespace aberfit {

double integral_in_pieces(const std::function<double(double)>& g, double a, double b,
                          const std::vector<double>& cuts) {
  static const Quadrature rule = gauss_legendre(24, 0.0, 1.0);
  std::vector<double> edges = {a};
  for (auto cut = std::upper_bound(cuts.begin(), cuts.end(), a); cut != cuts.end() && *cut < b; ++cut)
    edges.push_back(*cut);
  edges.push_back(b);
  double sum = 0;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const double width = edges[i + 1] - edges[i];
    for (Eigen::Index j = 0; j < rule.nodes.size(); ++j) {
      const double t = rule.nodes[j];
      sum += rule.weights[j] * width * 6 * t * (1 - t) * g(edges[i] + width * t * t * (3 - 2 * t));
    }
  }
  return sum;
}

double rectangle_variance(const RadialPsd& psd, double x0, double x1, double y0, double y1) {
  // Rounding may leave [0, 1]; acos and asin then use the nearest end.
  const auto ratio = [](double side, double f) { return std::min(1.0, side / f); };
  const auto angle = [&](double f) {
    const double from = std::max(std::acos(ratio(x1, f)), std::asin(ratio(y0, f)));
    const double to = std::min(std::acos(ratio(x0, f)), std::asin(ratio(y1, f)));
    return std::max(0.0, to - from);
  };
  const double inner = std::hypot(x0, y0), outer = std::hypot(x1, y1);
  std::vector<double> cuts = {x0, x1, y0, y1, std::hypot(x0, y1), std::hypot(x1, y0)};
  cuts.insert(cuts.end(), psd.breakpoints().begin(), psd.breakpoints().end());
  std::sort(cuts.begin(), cuts.end());
  return integral_in_pieces([&](double f) { return f * psd(f) * angle(f); }, std::max(inner, psd.f_min()),
                            std::max({inner, psd.f_min(), std::min(outer, psd.f_max())}), cuts);
}

std::vector<double> jumps(const RadialPsd& psd) {
  std::vector<double> found;
  for (const double f : psd.breakpoints()) {
    const double below = psd(f * (1 - 1e-9)), above = psd(f * (1 + 1e-9));
    if (std::abs(below - above) > 1e-3 * std::max(below, above)) found.push_back(f);
  }
  return found;
}

}  // namespace aberfit
