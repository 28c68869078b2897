#include <algorithm>
#include <boost/math/special_functions/beta.hpp>
#include <cassert>
#include <cmath>
#include <numbers>

#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/psd_table.h"

namespace aberfit {
namespace {

// Panels in u = acosh(x/f). The integrand (cosh u)^(-s-1) has its nearest singularity at i pi/2, so 12 nodes
// on a width of 0.7 have an error of 1e-22.
constexpr double kPanel = 0.7;
constexpr int kNodes = 12;

double acosh_ratio(double x, double f) {  // acosh(x/f) without cancellation near x = f
  const double d = (x - f) / f;
  return std::log1p(d + std::sqrt(d * (d + 2)));
}

}  // namespace

std::vector<double> abel_1d_to_2d(const std::vector<double>& frequency, const std::vector<double>& psd_1d,
                                  double tail_exponent) {
  assert(frequency.size() >= 2 && frequency.size() == psd_1d.size() && tail_exponent > 0);
  const Quadrature rule = gauss_legendre(kNodes, 0.0, 1.0);
  const std::size_t n = frequency.size();
  std::vector<double> exponent(n, tail_exponent);
  for (std::size_t i = 0; i + 1 < n; ++i)
    exponent[i] = -std::log(psd_1d[i + 1] / psd_1d[i]) / std::log(frequency[i + 1] / frequency[i]);
  std::vector<double> psd_2d(n);
  for (std::size_t at = 0; at < n; ++at) {
    const double f = frequency[at];
    double sum = 0;
    double u_lower = 0;
    for (std::size_t i = at; i + 1 < n; ++i) {
      // -S1' = s S1_i/x_i (x/x_i)^(-s-1), and dx/sqrt(x^2 - f^2) = du.
      const double u_upper = acosh_ratio(frequency[i + 1], f), s = exponent[i];
      const int panels = std::max(1, int(std::ceil((u_upper - u_lower) / kPanel)));
      const double width = (u_upper - u_lower) / panels;
      double integral = 0;
      for (int p = 0; p < panels; ++p)
        for (int k = 0; k < kNodes; ++k) {
          const double u = u_lower + (p + rule.nodes[k]) * width;
          integral += rule.weights[k] * width * std::pow(f * std::cosh(u) / frequency[i], -s - 1);
        }
      sum += s * psd_1d[i] / frequency[i] * integral;
      u_lower = u_upper;
    }
    // int_a^inf x^(-s-1) / sqrt(x^2 - f^2) dx = f^(-s-1)/2 B_z((s+1)/2, 1/2), z = (f/a)^2.
    const double a = frequency.back(), s = tail_exponent, z = std::pow(f / a, 2);
    sum += s * psd_1d.back() / a * 0.5 * std::pow(a / f, s + 1) * boost::math::beta(0.5 * (s + 1), 0.5, z);
    psd_2d[at] = sum / (2 * std::numbers::pi);
  }
  return psd_2d;
}

double fitted_tail_exponent(const std::vector<double>& frequency, const std::vector<double>& psd_1d) {
  assert(frequency.size() >= 2 && frequency.size() == psd_1d.size());
  const std::size_t n = frequency.size();
  std::size_t first = n - std::min<std::size_t>(n, 3);
  while (first > 0 && frequency[first - 1] >= 0.5 * frequency.back()) --first;
  double x_mean = 0, y_mean = 0, xx = 0, xy = 0;
  for (std::size_t i = first; i < n; ++i) {
    x_mean += std::log(frequency[i]) / double(n - first);
    y_mean += std::log(psd_1d[i]) / double(n - first);
  }
  for (std::size_t i = first; i < n; ++i) {
    const double x = std::log(frequency[i]) - x_mean;
    xx += x * x;
    xy += x * (std::log(psd_1d[i]) - y_mean);
  }
  return -xy / xx;
}

}  // namespace aberfit
