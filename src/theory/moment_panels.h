#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "panel_rule.h"

namespace aberfit::internal {

/// Moments of a pupil's overlap with itself over shear / cutoff, as polynomials.
struct MomentPanel {
  using Values = Eigen::Array<double, kPanelNodes, Eigen::Dynamic>;
  double a = 0, b = 0;
  Values value;  ///< (node, moment)

  /// At the nodes of [from, to] inside the panel.
  Values restricted(double from, double to) const;
  /// Legendre coefficients, (l, moment), and from them all moments at s inside the panel.
  Values legendre() const;
  Eigen::ArrayXd at(double s, const Values& legendre) const;
};
using MomentPanels = std::vector<MomentPanel>;

/// Of shears up to `end` <= 1, between the ascending `breakpoints`, the last of them 1, halved until what the
/// polynomials miss, told by their last two Legendre coefficients, is below `accuracy`. Throws
/// ComputationError for moments that are not finite and where three thousand panels do not suffice.
MomentPanels moment_panels(const std::function<Eigen::ArrayXd(double shear)>& moments,
                           const std::vector<double>& breakpoints, double end, double accuracy);

}  // namespace aberfit::internal
