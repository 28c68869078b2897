#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/roughness/psd.h"

namespace aberfit::internal {

/// Nodes over a band of frequencies for integrals whose lower limit varies. The panels are Gauss-Legendre, so
/// an integral from any frequency to the top is that of the polynomials through the nodes.
class FrequencyPanels {
 public:
  static constexpr int kNodes = 4;
  /// Panels between low and high, 0 < low < high [cycles/m], cut at the breakpoints of the PSD. Each is at
  /// most as wide as the larger of `width` and 5 % of its frequency.
  FrequencyPanels(const RadialPsd& psd, double low, double high, double width);

  const std::vector<double>& edges() const { return edges_; }
  const Eigen::ArrayXd& frequency() const { return frequency_; }  ///< nodes, ascending [cycles/m]
  Eigen::Index panels() const { return Eigen::Index(edges_.size()) - 1; }
  double width(Eigen::Index panel) const {
    return edges_[std::size_t(panel) + 1] - edges_[std::size_t(panel)];
  }
  /// Gauss-Legendre weights of a panel's nodes over its width.
  const Eigen::Array<double, kNodes, 1>& weights() const { return weights_; }

  /// A lower limit in [low, high]: its panel, and weights [cycles/m] of the nodes for the rest of the panel.
  struct Place {
    Eigen::Index panel = 0;
    Eigen::Array<double, kNodes, 1> weight;
  };
  Place place(double f) const;

 private:
  std::vector<double> edges_;
  Eigen::ArrayXd frequency_;
  Eigen::Array<double, kNodes, 1> nodes_, weights_;  // on [-1, 1]; weights sum to 1
};

/// Integrals of several functions from any frequency to the top of the band.
class TailIntegrals {
 public:
  /// integrand: nodes x functions.
  TailIntegrals(const FrequencyPanels& panels, Eigen::ArrayXXd integrand);
  /// Integrals from a place to the top, one per function, of non-negative integrands; clamped at 0.
  Eigen::ArrayXd from(const FrequencyPanels::Place& place) const;

 private:
  Eigen::ArrayXXd integrand_;  // functions x nodes
  Eigen::ArrayXXd above_;      // functions x edges: integrals from each edge on
};

}  // namespace aberfit::internal
