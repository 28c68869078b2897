#include "surface_transfer.h"

#include <algorithm>
#include <cmath>

namespace aberfit {
namespace {

// Legendre tail that a panel may keep: an encircled energy at v = 2 pi nu r turns it into at most sqrt(v)
// times as much. Weighted with the root of the panel's share of its own shear, which is what it can
// contribute.
constexpr double kResolved = 1e-12;
constexpr double kVanished = 1e-16;
constexpr int kMaxPanels = 3000;

bool resolved(const TransferPanel& panel) {
  return unresolved(panel) * std::sqrt((panel.b - panel.a) / panel.b) <= kResolved;
}

}  // namespace

SurfaceTransfer surface_transfer(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent,
                                 double limit, const SurfaceTransferOptions& options) {
  const double core = std::exp(-limit);
  const auto value = [&](double e) {
    // Small differences from the core keep their digits; large limits have no core.
    return limit < 30 ? core * std::expm1(limit - e) : std::exp(-e) - core;
  };
  std::vector<double> edges = options.breakpoints;
  // Octaves down to where E is small: samples of a wide panel could miss a transfer function that is gone at
  // once.
  Eigen::ArrayXd octaves(1 + int(std::ceil(std::log2(edges.front() / options.smallest))));
  for (int k = 0; k < octaves.size(); ++k) octaves[k] = edges.front() * std::ldexp(1.0, -k - 1);
  const Eigen::ArrayXd at_octaves = exponent(octaves);
  for (int k = 0; k < octaves.size(); ++k) {
    edges.push_back(octaves[k]);
    if (at_octaves[k] < 1e-3 * std::min(1.0, limit)) break;
  }
  edges.push_back(0);
  std::sort(edges.begin(), edges.end());
  std::vector<TransferPanel> pending;
  const int pieces = 1 << options.halvings;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i)
    for (int p = 0; p < pieces; ++p) {
      const double step = (edges[i + 1] - edges[i]) / pieces;
      pending.push_back(
          {(edges[i] + p * step) / options.cutoff,
           p + 1 == pieces ? edges[i + 1] / options.cutoff : (edges[i] + (p + 1) * step) / options.cutoff});
    }
  SurfaceTransfer result;
  while (!pending.empty()) {
    Eigen::ArrayXd shear(Eigen::Index(pending.size()) * kPanelNodes);
    for (std::size_t i = 0; i < pending.size(); ++i)
      shear.segment<kPanelNodes>(Eigen::Index(i) * kPanelNodes) = options.cutoff * pending[i].nodes();
    const Eigen::ArrayXd e = exponent(shear);
    std::vector<TransferPanel> halves;
    for (std::size_t i = 0; i < pending.size(); ++i) {
      TransferPanel& panel = pending[i];
      for (int j = 0; j < kPanelNodes; ++j) panel.value[j] = value(e[Eigen::Index(i) * kPanelNodes + j]);
      if (panel.value.abs().maxCoeff() < kVanished) panel.value.setZero();
      const bool wide = options.cutoff * (panel.b - panel.a) > options.smallest;
      if (wide && !resolved(panel)) {
        if (int(result.panels.size() + pending.size() + halves.size()) < kMaxPanels) {
          const double middle = 0.5 * (panel.a + panel.b);
          halves.push_back({panel.a, middle});
          halves.push_back({middle, panel.b});
          continue;
        }
        result.unresolved = std::max(result.unresolved, unresolved(panel));
      }
      result.panels.push_back(panel);
    }
    pending = std::move(halves);
  }
  std::sort(result.panels.begin(), result.panels.end(),
            [](const TransferPanel& one, const TransferPanel& two) { return one.a < two.a; });
  return result;
}

void append_product(const TransferPanel& panel, const std::function<double(double)>& otf,
                    std::vector<TransferPanel>* product) {
  if (panel.value.abs().maxCoeff() < kVanished) return;
  TransferPanel result = panel;
  const PanelArray s = panel.nodes();
  for (int j = 0; j < kPanelNodes; ++j) result.value[j] *= otf(s[j]);
  if (resolved(result) || panel.b - panel.a < 1e-10 * panel.b) {
    product->push_back(result);
  } else {
    append_product(lower_half(panel), otf, product);
    append_product(upper_half(panel), otf, product);
  }
}

}  // namespace aberfit
