#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/core/random.h"
#include "aberfit/core/root.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/terms/modal_covariance.h"
#include "fourier_shares.h"

namespace aberfit {
namespace {

using std::numbers::pi;
constexpr double kSameRing = 1e-9;  // relative difference of |f| that is rounding
constexpr double kOpenEndShare =
    1e-4;  // height variance beyond the outermost ring where the band has no edge to put it on

// The frequency below which `variance` of the height variance lies, looked for in log f.
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

// The band, or where it is open the quantiles of the height variance.
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
        pi * std::modf(turn + i * golden, &whole);  // the half plane: a wave and its opposite are one
    modes.push_back({f * std::cos(angle), f * std::sin(angle)});
  }
  return modes;
}

// Points (i, j) df of the half plane with |f| in the band; df is the largest spacing that gives `count` of
// them, and the outermost few that a tie of |f| brings too many are dropped.
std::vector<FourierMode> grid(const Edges& edges, int count) {
  const auto points = [&](double df) {
    std::vector<FourierMode> modes;
    const int reach = int(edges.high / df);
    for (int j = 0; j <= reach; ++j)
      for (int i = j == 0 ? 1 : -reach; i <= reach; ++i) {
        const double f = std::hypot(i * df, j * df);
        if (f >= edges.low && f <= edges.high) modes.push_back({i * df, j * df});
      }
    return modes;
  };
  const double area = 0.5 * pi * (edges.high - edges.low) * (edges.high + edges.low);
  double enough = std::sqrt(area / count), too_wide = enough;
  while (int(points(enough).size()) < count) enough *= 0.7;
  while (int(points(too_wide).size()) >= count) too_wide *= 1.4;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (enough + too_wide);
    (int(points(middle).size()) >= count ? enough : too_wide) = middle;
  }
  std::vector<FourierMode> modes = points(enough);
  std::stable_sort(modes.begin(), modes.end(), [](const FourierMode& a, const FourierMode& b) {
    return std::hypot(a.fx, a.fy) < std::hypot(b.fx, b.fy);
  });
  modes.resize(std::size_t(count));
  return modes;
}

}  // namespace

std::vector<FourierMode> fourier_modes(const RadialPsd& psd, int count, FourierSampling sampling,
                                       std::uint64_t seed) {
  assert(count > 0);
  if (sampling == FourierSampling::kGrid) return grid(sampled_edges(psd, true), count);
  return log_rings(sampled_edges(psd, false), count, seed);
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

}  // namespace internal
}  // namespace aberfit
