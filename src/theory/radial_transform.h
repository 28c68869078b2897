#pragma once
#include <array>
#include <vector>

#include "panel_rule.h"

namespace aberfit::internal {

/// Integrals of a transfer function T(s), given on ascending panels, with oscillating factors.
class RadialTransform {
 public:
  RadialTransform() = default;
  explicit RadialTransform(std::vector<TransferPanel> panels);

  struct Disc {
    double share = 0;       ///< int v J1(v s) T(s) ds
    double derivative = 0;  ///< over v: int v s J0(v s) T(s) ds
  };
  /// v >= 0. Panels on which v s changes by at most 8: Gauss-Legendre, vectorised. Farther out (v s >= 30):
  /// Filon's rule in Legendre form on the Hankel amplitude, at constant cost. In between: halved first.
  /// Panels with v s < 1/4: four moments of T. The error is that of T as a polynomial on each panel.
  Disc disc(double v) const;
  /// int cos(w s) T(s) ds.
  double cosine(double w) const;
  /// Derivative of `cosine` over w, -int s sin(w s) T(s) ds.
  double cosine_slope(double w) const;
  /// int s T(s) ds.
  double first_moment() const;
  /// T at the nodes of [a, b], which must not contain an edge of a panel; 0 where there is no panel.
  PanelArray on(double a, double b) const;
  /// T(s); 0 where there is no panel.
  double at(double s) const;
  const std::vector<TransferPanel>& panels() const { return panels_; }

 private:
  std::vector<TransferPanel> panels_;
  std::vector<double> s_, weighted_;            // nodes of all panels, and weight * T there
  std::vector<std::array<double, 4>> moments_;  // int s^(1,3,5,7) T ds up to the end of each panel
};

}  // namespace aberfit::internal
