#pragma once
#include <Eigen/Core>
#include <functional>
#include <limits>
#include <vector>

#include "aberfit/roughness/psd.h"
#include "aberfit/roughness/psd_derivative.h"
#include "panel_rule.h"

namespace aberfit::internal {

/// exp(-E(x)) - core of a rough surface over the pupil shear x = cutoff * s, resolved on panels in s over [0,
/// 1].
struct SurfaceTransfer {
  std::vector<TransferPanel> panels;
  double unresolved = 0;  ///< largest Legendre tail left when the panels ran out; 0 when all are resolved
};

struct SurfaceTransferOptions {
  double cutoff = 0;  ///< largest shear [m]
  std::vector<double>
      breakpoints;      ///< shears that must be panel edges, ascending, the last one the cutoff [m]
  double smallest = 0;  ///< shear below which nothing needs resolving [m]
  int halvings = 0;     ///< further halvings of every panel at the start
  /// Panels that are wider would be halved anyway, so they start narrower [m]: E oscillates with the highest
  /// frequency up to a shear.
  double widest = std::numeric_limits<double>::infinity(), widest_until = 0;
};

/// How C(0) - C(x) loses the oscillation of a sharp band edge: from `cycles` cycles of it on, completely at
/// twice as many, it is the mean over lags multiples of half a cycle apart, with these weights.
struct EdgeSoftening {
  double cycles;
  int inner, outer;  ///< half cycles
  double centre_weight, inner_weight, outer_weight;
};
Eigen::ArrayXd softened_structure(const RadialPsd& psd, const Eigen::ArrayXd& x, const EdgeSoftening& how);
/// The same of anything linear in S with a band that ends at f_max [cycles/m].
using LagFunction = std::function<Eigen::ArrayXd(const Eigen::ArrayXd& lag)>;
Eigen::ArrayXd softened(const LagFunction& half_structure, double f_max, const Eigen::ArrayXd& x,
                        const EdgeSoftening& how);

/// E(x) = (4 pi/lambda)^2 (C(0) - C(x)) at shears x >= 0 [m], far out with a softened band edge.
Eigen::ArrayXd surface_exponent(const RadialPsd& psd, double wavelength, const Eigen::ArrayXd& x);
/// dE/dp. psd: of the frequencies that scatter, of which `derivative` is the derivative.
Eigen::ArrayXd exponent_change(const RadialPsd& psd, const PsdDerivative& derivative, double wavelength,
                               const Eigen::ArrayXd& x);
/// With the shears between which the softening sets in as breakpoints.
SurfaceTransferOptions transfer_options(const RadialPsd& psd, double wavelength, double cutoff, int halvings);

/// Where panels over the shear begin and end [m]: the breakpoints, and octaves from the cutoff down to where
/// E is small. E grows at most fourfold in an octave, so that no panel can hide a transfer function that is
/// gone between its end and its first node.
std::vector<double> transfer_edges(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent,
                                   double limit, const SurfaceTransferOptions& options);

/// `exponent` gives E at an array of shears [m]; E tends to `limit` and core = exp(-limit).
SurfaceTransfer surface_transfer(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent,
                                 double limit, const SurfaceTransferOptions& options);

/// Appends panel * otf(s), halved until resolved; parts where the panel vanishes are left out.
void append_product(const TransferPanel& panel, const std::function<double(double)>& otf,
                    std::vector<TransferPanel>* product);

}  // namespace aberfit::internal
