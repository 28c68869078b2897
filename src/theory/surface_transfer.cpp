#include "surface_transfer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "aberfit/core/errors.h"

namespace aberfit::internal {
namespace {

// Largest Legendre tail of a resolved panel. An encircled energy at v = 2 pi nu r amplifies it by at most
// sqrt(v). The tail's weight, its possible contribution, is the root of the panel's width over its shear.
constexpr double kResolved = 1e-12;
constexpr double kVanished = 1e-16;
constexpr std::size_t kMaxPanels = 3000;
// Panels of an oscillating E start at most this many cycles of f_max wide: 24 nodes resolve 4 cycles to
// 1e-12, but never 8. kShownEdge is the least amplitude of the oscillation that counts.
constexpr double kCyclesOfPanel = 8, kShownEdge = 1e-9;
constexpr double kNarrowest = 1e-12;  // in units of the cutoff

// Cycles of the highest frequency within a shear, from which the band edge is softened. Encircled energies
// more than a few per cent away from the edge keep four digits (test ASoftenedBandEdgeMovesLittleLight).
constexpr double kSharpCycles = 100;
// Weights 1 4 6 4 1: the mean of J0(2 pi f x) far out is that of S cos^4.
constexpr EdgeSoftening kSoftEdge{kSharpCycles, 1, 2, 6, 4, 1};

bool resolved(const TransferPanel& panel) {
  return unresolved(panel) * std::sqrt((panel.b - panel.a) / panel.b) <= kResolved;
}

// Largest number of halvings of one panel, which is then as wide as rounding; also ends them at NaN.
constexpr int kMaxHalvings = 48;
// Largest number of panels of one product; the rest stays as it is, and `unresolved` gives its error.
constexpr std::size_t kMaxProduct = 200000;

bool is_done(const TransferPanel& panel, int halvings, std::size_t panels) {
  if (!panel.value.isFinite().all())
    throw ComputationError("the transfer function of this aperture is not finite in this plane");
  return resolved(panel) || panel.b - panel.a < 1e-10 * panel.b || halvings >= kMaxHalvings ||
         panels >= kMaxProduct;
}

// Appends the panel that `panel_on` makes on [a, b], halved until it is done; nothing where it vanishes.
template <class PanelOn>
void append_halved(const PanelOn& panel_on, double a, double b, int halvings,
                   std::vector<TransferPanel>* panels) {
  TransferPanel panel{a, b};
  if (!panel_on(&panel)) return;
  if (is_done(panel, halvings, panels->size())) {
    panels->push_back(panel);
  } else {
    append_halved(panel_on, a, 0.5 * (a + b), halvings + 1, panels);
    append_halved(panel_on, 0.5 * (a + b), b, halvings + 1, panels);
  }
}

PanelArray at_nodes(const std::function<double(double)>& f, const TransferPanel& panel) {
  return panel.nodes().unaryExpr([&](double s) { return f(s); });
}

}  // namespace

Eigen::ArrayXd softened(const LagFunction& function, double f_max, const Eigen::ArrayXd& x,
                        const EdgeSoftening& how) {
  Eigen::ArrayXd half_structure = function(x);
  const double sharp = how.cycles / f_max;
  std::vector<Eigen::Index> far;
  for (Eigen::Index i = 0; i < x.size(); ++i)
    if (sharp > 0 && x[i] > sharp) far.push_back(i);
  if (far.empty()) return half_structure;
  const std::array<int, 4> shifts{-how.outer, -how.inner, how.inner, how.outer};
  const Eigen::Index count = Eigen::Index(far.size());
  Eigen::ArrayXd shifted(4 * count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (int j = 0; j < 4; ++j)
      shifted[4 * i + j] = x[far[std::size_t(i)]] + 0.5 * shifts[std::size_t(j)] / f_max;
  const Eigen::ArrayXd values = function(shifted);
  const double all = how.centre_weight + 2 * (how.inner_weight + how.outer_weight);
  for (Eigen::Index i = 0; i < count; ++i) {
    double& here = half_structure[far[std::size_t(i)]];
    const double* const value = &values[4 * i];
    const double mean = (how.outer_weight * (value[0] + value[3]) + how.inner_weight * (value[1] + value[2]) +
                         how.centre_weight * here) /
                        all;
    const double t = std::min(1.0, x[far[std::size_t(i)]] / sharp - 1);
    const double share = t * t * t * (10 - t * (15 - 6 * t));  // smooth from 0 to 1 between the two shears
    here += share * (mean - here);
  }
  return half_structure;
}

Eigen::ArrayXd softened_structure(const RadialPsd& psd, const Eigen::ArrayXd& x, const EdgeSoftening& how) {
  return softened([&](const Eigen::ArrayXd& r) { return structure_function(psd, r); }, psd.f_max(), x, how);
}

Eigen::ArrayXd surface_exponent(const RadialPsd& psd, double wavelength, const Eigen::ArrayXd& x) {
  const double k = 4 * std::numbers::pi / wavelength;
  return k * k * softened_structure(psd, x, kSoftEdge);
}

Eigen::ArrayXd exponent_change(const RadialPsd& psd, const PsdDerivative& derivative, double wavelength,
                               const Eigen::ArrayXd& x) {
  const double k = 4 * std::numbers::pi / wavelength;
  Eigen::ArrayXd change = softened([&](const Eigen::ArrayXd& r) { return derivative.structure_function(r); },
                                   psd.f_max(), x, kSoftEdge);
  const double moved = derivative.highest_frequency();
  if (moved == 0 || !(x.size() > 0 && x.maxCoeff() * psd.f_max() > kSharpCycles)) return k * k * change;
  // The softening moves with the edge, too: a small smooth change, by fourth-order differences.
  const auto moved_edge = [&](double by) {
    return softened([&](const Eigen::ArrayXd& r) { return structure_function(psd, r); },
                    psd.f_max() * (1 + by), x, kSoftEdge);
  };
  constexpr double kStep = 2e-3;
  change += moved / (12 * kStep * psd.f_max()) *
            (8 * (moved_edge(kStep) - moved_edge(-kStep)) - moved_edge(2 * kStep) + moved_edge(-2 * kStep));
  return k * k * change;
}

// Shear [m], at most `most`, up to which the sharp end of the band shows in E. A step S(f_max) adds to half
// the structure function an oscillation f_max S J1(2 pi f_max x)/x.
double edge_matters_until(const RadialPsd& psd, double wavelength, double most) {
  const double f = psd.f_max(), k = 4 * std::numbers::pi / wavelength;
  if (!(std::isfinite(f) && most > 0)) return 0;
  const double wave = k * k * psd(f) * f / (most * std::numbers::pi * std::sqrt(f * most));
  return wave > kShownEdge ? most : 0;
}

SurfaceTransferOptions transfer_options(const RadialPsd& psd, double wavelength, double cutoff,
                                        int halvings) {
  SurfaceTransferOptions transfer;
  transfer.cutoff = cutoff;
  const double sharp = kSharpCycles / psd.f_max();
  for (const double x : {sharp, 2 * sharp})
    if (x > 0 && x < cutoff) transfer.breakpoints.push_back(x);
  transfer.smallest = 1e-8 * wavelength;  // so that v s stays below 1e-7 up to r = f
  transfer.halvings = halvings;
  transfer.widest = kCyclesOfPanel / psd.f_max();
  transfer.widest_until = edge_matters_until(psd, wavelength, std::min(2 * sharp, cutoff));
  return transfer;
}

std::vector<double> transfer_edges(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent,
                                   double limit, const SurfaceTransferOptions& options) {
  std::vector<double> edges = options.breakpoints;
  edges.push_back(options.cutoff);
  // Octaves down to where E is small. E grows at most fourfold in each, so the transfer function cannot
  // vanish unseen between the end of a panel and its first node.
  Eigen::ArrayXd octaves(1 + std::max(0, int(std::ceil(std::log2(options.cutoff / options.smallest)))));
  for (int k = 0; k < octaves.size(); ++k) octaves[k] = options.cutoff * std::ldexp(1.0, -k - 1);
  const Eigen::ArrayXd at_octaves = exponent(octaves);
  for (int k = 0; k < octaves.size(); ++k) {
    edges.push_back(octaves[k]);
    if (at_octaves[k] < 1e-3 * std::min(1.0, limit)) break;
  }
  edges.push_back(0);
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

SurfaceTransfer surface_transfer(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent,
                                 double limit, const SurfaceTransferOptions& options) {
  const double core = std::exp(-limit);
  const auto value = [&](double e) {
    // Small differences from the core keep their digits; large limits have no core.
    return limit < 30 ? core * std::expm1(limit - e) : std::exp(-e) - core;
  };
  const std::vector<double> edges = transfer_edges(exponent, limit, options);
  std::vector<TransferPanel> pending;
  const int pieces = 1 << options.halvings;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i)
    for (int p = 0; p < pieces; ++p) {
      const double step = (edges[i + 1] - edges[i]) / pieces;
      pending.push_back(
          {(edges[i] + p * step) / options.cutoff,
           p + 1 == pieces ? edges[i + 1] / options.cutoff : (edges[i] + (p + 1) * step) / options.cutoff});
    }
  const auto missing = [&](TransferPanel* panel) {
    if (panel->value.abs().maxCoeff() < kVanished) panel->value.setZero();
    const bool wide = options.cutoff * (panel->b - panel->a) > options.smallest;
    return wide && !resolved(*panel) ? unresolved(*panel) : 0;
  };
  SurfaceTransfer result;
  result.unresolved = refine(
      std::move(pending), kMaxPanels,
      [&](const Eigen::ArrayXd& s) -> Eigen::ArrayXd {
        return exponent(options.cutoff * s).unaryExpr(value);
      },
      missing, &result.panels);
  return result;
}

void append_product(const TransferPanel& panel, const std::function<double(double)>& otf,
                    std::vector<TransferPanel>* product) {
  const auto panel_on = [&](TransferPanel* part) {
    part->value = restricted(panel, part->a, part->b);
    if (part->value.abs().maxCoeff() < kVanished) return false;
    part->value *= at_nodes(otf, *part);
    return true;
  };
  append_halved(panel_on, panel.a, panel.b, 0, product);
}

}  // namespace aberfit::internal
