#include "pattern_table.h"

#include <algorithm>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <vector>

#include "aberfit/core/quadrature.h"

namespace aberfit {
namespace {

constexpr int kClasses = 14;
constexpr double kSmallest = 32;
// A circle of this radius holds 99.7 % of the pattern of a circular aperture.
constexpr double kTail = 400;

using Policy = boost::math::policies::policy<boost::math::policies::promote_double<false>>;
double bessel(int order, double x) { return boost::math::cyl_bessel_j(order, x, Policy()); }

}  // namespace

int pattern_table_class(double u) {
  int size = 0;
  while (size + 1 < kClasses && pattern_table_longest(size) < u) ++size;
  return size;
}

double pattern_table_longest(int size_class) { return kSmallest * std::pow(2.0, 0.5 * size_class); }

const PatternTable::Stencil& PatternTable::stencil() {
  static const Stencil matrix = [] {
    Stencil result;
    constexpr int kNodes = kDegree + 1;
    const auto node = [](int i) { return i - 0.5 * kDegree; };
    for (int i = 0; i < kNodes; ++i) {  // Lagrange's polynomial of node i, multiplied out
      Eigen::Matrix<double, kNodes, 1> polynomial = Eigen::Matrix<double, kNodes, 1>::Zero();
      polynomial[0] = 1;
      for (int j = 0, degree = 0; j < kNodes; ++j) {
        if (j == i) continue;
        ++degree;
        for (int k = degree; k >= 0; --k)
          polynomial[k] = ((k > 0 ? polynomial[k - 1] : 0) - node(j) * polynomial[k]) / (node(i) - node(j));
      }
      result.col(i) = polynomial;
    }
    return result;
  }();
  return matrix;
}

PatternRule::PatternRule(const ApertureOtf& otf, double phase) {
  std::vector<double> ends{0.0};
  for (const double x : otf.breakpoints()) ends.push_back(x / otf.cutoff());
  std::vector<Quadrature> parts;
  Eigen::Index count = 0;
  for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
    // n nodes integrate cos(beta t) over [-1, 1] to rounding from 2 n = beta + some of its cube root on; at
    // the ends, where the OTF goes as a power 3/2, they err by n^-5.
    const double beta = 0.5 * (ends[k + 1] - ends[k]) * phase;
    parts.push_back(gauss_legendre(int(0.5 * beta + 4 * std::cbrt(beta)) + 48, ends[k], ends[k + 1]));
    count += parts.back().nodes.size();
  }
  s.resize(count);
  weight.resize(count);
  Eigen::Index at = 0;
  for (const Quadrature& part : parts) {
    s.segment(at, part.nodes.size()) = part.nodes;
    weight.segment(at, part.nodes.size()) = part.weights;
    at += part.nodes.size();
  }
  for (Eigen::Index j = 0; j < count; ++j) weight[j] *= otf(s[j] * otf.cutoff());
}

Eigen::ArrayXd PatternRule::disc(double v) const {
  return v * s.unaryExpr([v](double node) { return aberfit::bessel(1, v * node); });
}

Eigen::ArrayXd PatternRule::disc_slope(double v) const {
  return v * s * s.unaryExpr([v](double node) { return aberfit::bessel(0, v * node); });
}

PatternTable::PatternTable(const ApertureOtf& otf, double u)
    : longest(u), largest_v(u + kTail), rule(otf, longest + largest_v) {
  const Eigen::ArrayXd& s = rule.s;
  bessel.resize(s.size(), Eigen::Index(std::ceil(longest / kStep)) + 2 + (kDegree + 1) / 2);
  for (Eigen::Index b = 0; b < bessel.cols(); ++b)
    for (Eigen::Index j = 0; j < s.size(); ++j) bessel(j, b) = aberfit::bessel(0, s[j] * (kStep * double(b)));
}

}  // namespace aberfit
