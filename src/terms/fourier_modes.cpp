#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "aberfit/core/errors.h"
#include "aberfit/core/random.h"
#include "aberfit/core/root.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/roughness/spectrum_cells.h"
#include "aberfit/terms/modal_covariance.h"
#include "fourier_shares.h"

namespace aberfit {
namespace {

using std::numbers::pi;
constexpr double kSameRing = 1e-9;      // smaller relative differences of |f| are rounding
constexpr double kOpenEndShare = 1e-4;  // height variance beyond the outermost ring if the band has no edge

// The frequency below which `variance` of the height variance lies, found in log f.
double quantile_frequency(const RadialPsd& psd, double variance) {
  const PowerLawLimits limits = power_law_limits(psd);
  double low = std::log(limits.low) - 700 * (psd.f_min() == 0),
         high = std::log(limits.high) + 100 * std::isinf(psd.f_max());
  low = std::max(low, -690.0);
  const auto excess = [&](double log_f) { return radial_moment(psd, 0, 0, std::exp(log_f)) - variance; };
  return std::exp(root_between(excess, low, high, excess(low), excess(high)));
}

struct Edges {
  double low, high;
};

// The edges of the band or, at an open end, quantiles of the height variance.
Edges sampled_edges(const RadialPsd& psd, bool from_zero) {
  const double total = radial_moment(psd, 0);
  if (!std::isfinite(total) || total <= 0)
    throw ComputationError("Fourier modes need a PSD whose height variance is finite and not zero");
  Edges edges{psd.f_min(), psd.f_max()};
  if (edges.low == 0 && !from_zero) edges.low = quantile_frequency(psd, kOpenEndShare * total);
  if (std::isinf(edges.high)) edges.high = quantile_frequency(psd, (1 - kOpenEndShare) * total);
  return edges;
}

std::vector<FourierMode> log_rings(const Edges& edges, int count, std::uint64_t seed) {
  const RandomStream stream(seed, "fourier-modes");
  const double golden = std::numbers::phi - 1, turn = stream.uniform_pair(0)[1];
  std::vector<FourierMode> modes;
  for (int i = 0; i < count; ++i) {
    const double jitter = stream.uniform(std::uint64_t(i));
    const double f = edges.low * std::pow(edges.high / edges.low, (i + jitter) / count);
    double whole;
    const double angle =
        pi * std::modf(turn + i * golden, &whole);  // half plane only, because f and -f are one wave
    modes.push_back({f * std::cos(angle), f * std::sin(angle)});
  }
  return modes;
}

// Returns whether the square of side `pitch` about (i, j) pitch overlaps the ring in more than an edge.
bool has_part(int i, int j, double pitch, const Edges& edges) {
  const double x = std::abs(i), y = std::abs(j);
  const double nearest = pitch * std::hypot(std::max(x - 0.5, 0.0), std::max(y - 0.5, 0.0)),
               farthest = pitch * std::hypot(x + 0.5, y + 0.5);
  return nearest < edges.high * (1 - kSameRing) && farthest > edges.low * (1 + kSameRing);
}

}  // namespace

std::vector<FourierMode> fourier_modes(const RadialPsd& psd, int count, std::uint64_t seed) {
  assert(count > 0);
  return log_rings(sampled_edges(psd, false), count, seed);
}

std::vector<FourierMode> fourier_lattice(const RadialPsd& psd, double pitch) {
  assert(pitch > 0);
  const RadialPsd beyond = psd.band(0.5 * pitch, psd.f_max());
  if (!(beyond.f_max() > 0.5 * pitch)) return {};  // all of it lies in the cell of 0
  const Edges edges = sampled_edges(beyond, true);
  const double reach = edges.high / pitch + 0.5, count = 0.5 * pi * reach * reach;
  if (count > kMostLatticeModes)
    throw ComputationError(
        fmt::format("the band up to {:.4g} /m needs {:.2g} plane waves on a grid of {:.4g} /m, more than the "
                    "allowed {:.2g}",
                    edges.high, count, pitch, kMostLatticeModes));
  std::vector<FourierMode> modes;
  const int most = int(reach);
  for (int j = 0; j <= most; ++j)
    for (int i = j == 0 ? 1 : -most; i <= most; ++i)
      if (has_part(i, j, pitch, edges)) modes.push_back({i * pitch, j * pitch});
  std::stable_sort(modes.begin(), modes.end(), [](const FourierMode& a, const FourierMode& b) {
    return std::hypot(a.fx, a.fy) < std::hypot(b.fx, b.fy);
  });
  return modes;
}

namespace internal {

std::vector<double> fourier_variances(const RadialPsd& psd, const std::vector<FourierMode>& modes) {
  std::vector<double> frequency(modes.size()), variance(modes.size(), 0.0);
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    frequency[i] = std::hypot(modes[i].fx, modes[i].fy);
    if (frequency[i] >= psd.f_min() * (1 - kSameRing) && frequency[i] <= psd.f_max() * (1 + kSameRing))
      order.push_back(i);
  }
  if (!std::isfinite(radial_moment(psd, 0)))
    throw ComputationError("Fourier modes need a PSD whose height variance is finite");
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return frequency[a] < frequency[b]; });
  double lower = psd.f_min();
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    while (end < order.size() && frequency[order[end]] <= frequency[order[end - 1]] * (1 + kSameRing)) ++end;
    const double upper = end == order.size()
                             ? psd.f_max()
                             : std::sqrt(frequency[order[end - 1]]) * std::sqrt(frequency[order[end]]);
    const double share = radial_moment(psd, 0, lower, upper) / double(end - begin);
    for (std::size_t k = begin; k < end; ++k) variance[order[k]] = share;
    lower = upper;
    begin = end;
  }
  return variance;
}

std::vector<double> lattice_variances(const RadialPsd& psd, const std::vector<FourierMode>& modes,
                                      double pitch) {
  std::map<std::pair<long, long>, double> known;  // S depends only on |x| and |y| and is symmetric in them
  std::vector<double> variance;
  variance.reserve(modes.size());
  for (const FourierMode& mode : modes) {
    const long i = std::lround(std::abs(mode.fx) / pitch), j = std::lround(std::abs(mode.fy) / pitch);
    const std::pair<long, long> place{std::min(i, j), std::max(i, j)};
    const auto [found, is_new] = known.try_emplace(place, 0.0);
    if (is_new) {
      // We integrate half of a cell across the axis. A and B of one wave represent the cells about f and -f.
      const double across = place.first == 0 ? 2.0 : 1.0;
      const double low = place.first == 0 ? 0.0 : double(place.first) - 0.5;
      found->second =
          2 * across *
          rectangle_variance(psd, pitch * (double(place.second) - 0.5), pitch * (double(place.second) + 0.5),
                             pitch * low, pitch * (double(place.first) + 0.5));
    }
    variance.push_back(found->second);
  }
  return variance;
}

}  // namespace internal
}  // namespace aberfit
