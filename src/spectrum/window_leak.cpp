#include "window_leak.h"

#include <algorithm>
#include <cmath>

namespace aberfit::internal {
namespace {

constexpr double kFirstBin = 16;  // frequency steps; half of it is beyond the main lobe of any window

// Interpolates the bins log-log at the nodes of the response; constant beyond them.
Eigen::ArrayXd psd_at_nodes(const PsdEstimate& estimate) {
  const Eigen::ArrayXd f = estimate.frequency.log(), s = estimate.psd.max(1e-300).log();
  return estimate.node_frequency.log().unaryExpr([&](double x) {
    const Eigen::Index above = std::upper_bound(f.begin(), f.end(), x) - f.begin();
    const Eigen::Index j = std::clamp<Eigen::Index>(above, 1, f.size() - 1);
    const double t = std::clamp((x - f[j - 1]) / (f[j] - f[j - 1]), 0.0, 1.0);
    return std::exp((1 - t) * s[j - 1] + t * s[j]);
  });
}

}  // namespace

std::optional<WindowLeak> window_leak(const PsdEstimate& estimate) {
  if (estimate.frequency.size() < 2) return std::nullopt;
  const Eigen::ArrayXd psd = psd_at_nodes(estimate);
  std::optional<WindowLeak> leak;
  for (Eigen::Index b = 0; b < estimate.psd.size(); ++b) {
    const double f = estimate.frequency[b];
    if (f < kFirstBin * estimate.resolution || f > estimate.trusted_to) continue;
    const Eigen::ArrayXd from = estimate.response.row(b).transpose().array() * psd;
    const double share = (estimate.node_frequency < 0.5 * f).select(from, 0).sum() / from.sum();
    if (!(share > kMostLeaked)) continue;
    if (!leak) leak = WindowLeak{f, share};
    leak->share = std::max(leak->share, share);
  }
  return leak;
}

}  // namespace aberfit::internal
