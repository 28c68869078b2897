#pragma once
#include <Eigen/Core>

#include "aberfit/theory/aperture_otf.h"

namespace aberfit {

/// Quadrature over spatial frequency s, in cut-off frequencies of the aperture: sum of weight g(s) is the
/// integral of OTF g for g that turns through no more than `phase` radians over the band.
struct PatternRule {
  Eigen::ArrayXd s, weight;
  PatternRule(const ApertureOtf& otf, double phase);

  /// V J1(V s): what energies within V weight J0(u s) with, and its derivative over V.
  Eigen::ArrayXd disc(double v) const;
  Eigen::ArrayXd disc_slope(double v) const;
};

/// J0 at distances and frequencies for one range of distances u and radii V, both in radians per cut-off
/// frequency: u = 2 pi nu_c r.
struct PatternTable {
  static constexpr int kDegree = 9;
  static constexpr double kStep = 0.4;  // of u: interpolation of J0(u s), s <= 1, errs by 1e-8 and less
  /// Coefficient of t^k, t in [-1/2, 1/2] from the middle of an interval, from the values at the ten nodes
  /// around it.
  using Stencil = Eigen::Matrix<double, kDegree + 1, kDegree + 1>;
  static const Stencil& stencil();

  double longest = 0;    ///< largest u
  double largest_v = 0;  ///< largest V
  PatternRule rule;
  Eigen::MatrixXd bessel;  ///< J0(s_j u_b), u_b = b kStep: nodes x distances

  /// Table for u up to at least `longest`.
  PatternTable(const ApertureOtf& otf, double longest);
  Eigen::Index intervals() const { return bessel.cols() - (kDegree + 1) / 2; }
};

/// Sizes in which tables come: 32, 45, 64, ... up to 2896. The class that holds u, or the last.
int pattern_table_class(double u);
double pattern_table_longest(int size_class);

}  // namespace aberfit
