#pragma once
#include <Eigen/Core>
#include <functional>
#include <limits>
#include <vector>

#include "aberfit/roughness/psd.h"
#include "aberfit/roughness/psd_derivative.h"
#include "panel_rule.h"

namespace aberfit::internal {

/// exp(-E(x)) - core of a rough surface over the shear x = cutoff * s, on panels in s over [0, 1].
struct SurfaceTransfer {
  std::vector<TransferPanel> panels;
  double unresolved = 0;  ///< largest Legendre tail left when the panels ran out; 0 when all are resolved
};

struct SurfaceTransferOptions {
  double cutoff = 0;  ///< largest shear [m]
  std::vector<double>
      breakpoints;      ///< shears that must be panel edges, ascending, the last one the cutoff [m]
  double smallest = 0;  ///< shear below which nothing needs resolving [m]
  int halvings = 0;     ///< number of initial halvings of every panel
  /// Panels up to `widest_until` start at most this wide [m]: E oscillates with the highest frequency.
  double widest = std::numeric_limits<double>::infinity(), widest_until = 0;
};

/// Removes the oscillation of a sharp band edge from C(0) - C(x). From `cycles` cycles on, and completely at
/// twice as many, it takes the weighted mean over lags that are multiples of half a cycle apart.
struct EdgeSoftening {
  double cycles;
  int inner, outer;  ///< in half cycles
  double centre_weight, inner_weight, outer_weight;
};
Eigen::ArrayXd softened_structure(const RadialPsd& psd, const Eigen::ArrayXd& x, const EdgeSoftening& how);
/// The same for any quantity that is linear in S and has a band that ends at f_max [cycles/m].
using LagFunction = std::function<Eigen::ArrayXd(const Eigen::ArrayXd& lag)>;
Eigen::ArrayXd softened(const LagFunction& half_structure, double f_max, const Eigen::ArrayXd& x,
                        const EdgeSoftening& how);

/// E(x) = (4 pi/lambda)^2 (C(0) - C(x)) at shears x >= 0 [m], far out with a softened band edge.
Eigen::ArrayXd surface_exponent(const RadialPsd& psd, double wavelength, const Eigen::ArrayXd& x);
/// dE/dp. psd: the frequencies that scatter; `derivative` is its derivative.
Eigen::ArrayXd exponent_change(const RadialPsd& psd, const PsdDerivative& derivative, double wavelength,
                               const Eigen::ArrayXd& x);
/// Options with breakpoints at the shears between which the softening sets in.
SurfaceTransferOptions transfer_options(const RadialPsd& psd, double wavelength, double cutoff, int halvings);

/// Edges of the panels over the shear [m]: the breakpoints, and octaves from the cutoff down to where E is
/// small. E grows at most fourfold in an octave, so the transfer function cannot vanish unseen between the
/// end of a panel and its first node.
std::vector<double> transfer_edges(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent,
                                   double limit, const SurfaceTransferOptions& options);

/// exponent: E at an array of shears [m]; E tends to `limit`, and core = exp(-limit).
SurfaceTransfer surface_transfer(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent,
                                 double limit, const SurfaceTransferOptions& options);

/// Appends panel * otf(s), halved until resolved; parts where the panel vanishes are left out.
void append_product(const TransferPanel& panel, const std::function<double(double)>& otf,
                    std::vector<TransferPanel>* product);

}  // namespace aberfit::internal
