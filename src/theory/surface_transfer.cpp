#include "surface_transfer.h"

#include <algorithm>
#include <cmath>

namespace aberfit::internal {
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

namespace {

void append_otf(const std::function<double(double)>& otf, double a, double b,
                std::vector<TransferPanel>* panels) {
  TransferPanel panel{a, b};
  const PanelArray s = panel.nodes();
  for (int j = 0; j < kPanelNodes; ++j) panel.value[j] = otf(s[j]);
  if (resolved(panel) || b - a < 1e-10 * b) {
    panels->push_back(panel);
  } else {
    append_otf(otf, a, 0.5 * (a + b), panels);
    append_otf(otf, 0.5 * (a + b), b, panels);
  }
}

void append_overlap(const TransferPanel& one, const TransferPanel& two, double a, double b, double constant,
                    std::vector<TransferPanel>* product) {
  TransferPanel result{a, b};
  const PanelArray first = restricted(one, a, b) + constant;
  if (first.abs().maxCoeff() < kVanished) return;
  result.value = first * restricted(two, a, b);
  if (resolved(result) || b - a < 1e-10 * b) {
    product->push_back(result);
  } else {
    append_overlap(one, two, a, 0.5 * (a + b), constant, product);
    append_overlap(one, two, 0.5 * (a + b), b, constant, product);
  }
}

}  // namespace

std::vector<TransferPanel> resolved_otf(const std::function<double(double)>& otf,
                                        const std::vector<double>& breakpoints, double end) {
  std::vector<TransferPanel> panels;
  double a = 0;
  for (double b : breakpoints) {
    b = std::min(b, end);
    if (b > a) append_otf(otf, a, b, &panels);
    a = std::max(a, b);
  }
  return panels;
}

std::vector<TransferPanel> product(const std::vector<TransferPanel>& transfer, double constant,
                                   const std::vector<TransferPanel>& otf) {
  std::vector<TransferPanel> result;
  std::size_t j = 0;
  for (const TransferPanel& panel : transfer) {
    if ((panel.value + constant).abs().maxCoeff() < kVanished) continue;
    while (j > 0 && otf[j].a > panel.a) --j;
    while (j < otf.size() && otf[j].b <= panel.a) ++j;
    for (; j < otf.size() && otf[j].a < panel.b; ++j) {
      const double a = std::max(panel.a, otf[j].a), b = std::min(panel.b, otf[j].b);
      if (b > a) append_overlap(panel, otf[j], a, b, constant, &result);
      if (otf[j].b > panel.b) break;
    }
    if (j == otf.size()) break;
  }
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

}  // namespace aberfit::internal
