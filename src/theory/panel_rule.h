#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "aberfit/roughness/psd_integrals.h"

namespace aberfit::internal {

/// Gauss-Legendre rule of kPanelNodes points on [-1, 1], and operations on the polynomial through them.
struct PanelRule {
  using Matrix = Eigen::Matrix<double, kPanelNodes, kPanelNodes>;
  PanelArray t, weight;
  PanelArray last, last_but_one;  ///< value . last: highest Legendre coefficient, then the next
  Matrix legendre;                ///< (l, node): Legendre coefficients from values
  Matrix left, right;             ///< values at the nodes of the lower and of the upper half
};
/// Constant, computed at first use.
const PanelRule& panel_rule();

/// A function on [a, b], given by its values at the nodes of the panel.
struct TransferPanel {
  double a = 0, b = 0;
  PanelArray value = PanelArray::Zero();

  PanelArray nodes() const { return 0.5 * (a + b) + 0.5 * (b - a) * panel_rule().t; }
};
/// A function of the shear as polynomials on panels, ascending and without gaps.
struct PanelFunction {
  std::vector<TransferPanel> panels;
  std::vector<PanelArray> legendre;  ///< coefficients of each panel

  void set_coefficients();
  /// The panel that x lies in, or the last one.
  std::size_t panel_at(double x) const;
  double at(double x, std::size_t panel) const;
  /// x inside the panel.
  PanelArray at(const PanelArray& x, std::size_t panel) const;
};

/// Halves panels until nothing is missing; `panels` is in ascending order. values: the function at many
/// points, panel after panel. missing: the error of a panel with its values, 0 if it is done; it may change
/// the values. At most about `most` panels. Returns the largest error that is left, else 0.
double refine(std::vector<TransferPanel> pending, std::size_t most,
              const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& values,
              const std::function<double(TransferPanel*)>& missing, std::vector<TransferPanel>* panels);
/// Error estimate of the polynomial through the nodes, from its last two Legendre coefficients.
double unresolved(const TransferPanel& panel);
/// The lower and upper half, by interpolation.
TransferPanel lower_half(const TransferPanel& panel);
TransferPanel upper_half(const TransferPanel& panel);
/// Values at the nodes of [a, b] inside the panel, by interpolation.
PanelArray restricted(const TransferPanel& panel, double a, double b);

}  // namespace aberfit::internal
