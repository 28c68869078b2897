#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

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
};

/// `exponent` gives E at an array of shears [m]; E tends to `limit` and core = exp(-limit).
SurfaceTransfer surface_transfer(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent,
                                 double limit, const SurfaceTransferOptions& options);

/// Panels that resolve otf over [0, end], cut at the ascending breakpoints.
std::vector<TransferPanel> resolved_otf(const std::function<double(double)>& otf,
                                        const std::vector<double>& breakpoints, double end);
/// (transfer + constant) * otf on their common refinement, halved until resolved. Both ascending.
std::vector<TransferPanel> product(const std::vector<TransferPanel>& transfer, double constant,
                                   const std::vector<TransferPanel>& otf);

/// Appends panel * otf(s), halved until resolved; parts where the panel vanishes are left out.
void append_product(const TransferPanel& panel, const std::function<double(double)>& otf,
                    std::vector<TransferPanel>* product);

}  // namespace aberfit::internal
