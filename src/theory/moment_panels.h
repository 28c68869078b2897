#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "panel_rule.h"

namespace aberfit::internal {

/// Chebyshev polynomials in two numbers of [0, 1], `order` in each, and their interpolation nodes.
struct MomentBasis {
  explicit MomentBasis(int order);
  int order;
  std::vector<double> nodes;  ///< ascending
  Eigen::MatrixXd lagrange;   ///< (i, p): part of polynomial p in the Lagrange polynomial of node i
  /// Moments of the Lagrange polynomials, i major, from those of the Chebyshev polynomials (p, q).
  Eigen::ArrayXd at_nodes(const Eigen::MatrixXd& by_chebyshev) const;
};

/// Moments of a pupil's overlap with its copy over shear / cutoff, as polynomials.
struct MomentPanel {
  using Values = Eigen::Array<double, kPanelNodes, Eigen::Dynamic>;
  double a = 0, b = 0;
  Values value;  ///< (node, moment)

  /// Values at the nodes of [from, to] inside the panel.
  Values restricted(double from, double to) const;
  /// Legendre coefficients (l, moment); `at` takes them and returns all moments at s inside the panel.
  Values legendre() const;
  Eigen::ArrayXd at(double s, const Values& legendre) const;
};
using MomentPanels = std::vector<MomentPanel>;

/// Panels for shears up to `end` <= 1 between the ascending `breakpoints`, the last of which is 1. They are
/// halved until the last two Legendre coefficients show an error below `accuracy`. Throws ComputationError
/// for moments that are not finite and where three thousand panels do not suffice.
MomentPanels moment_panels(const std::function<Eigen::ArrayXd(double shear)>& moments,
                           const std::vector<double>& breakpoints, double end, double accuracy);

}  // namespace aberfit::internal
