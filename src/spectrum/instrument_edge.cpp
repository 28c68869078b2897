#include "instrument_edge.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "aberfit/core/constants.h"
#include "psd_shape_fit.h"

namespace aberfit::internal {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

// No polished surface is steeper than this beyond chance. The profile dabam-022 falls as f^-5.2 below the end
// of its instrument's band and as f^-9.9 beyond. The exponents of surfaces are larger by one.
constexpr double kSteepestProfile = 6, kSteepestSurface = 7;
constexpr double kCliff = 8;  // factor below the extrapolated line that a cliff must reach
constexpr double kGoesOn = 3, kGoesOnWithinChance = 3;  // factor, standard deviations
constexpr double kBeyondChance = 4;                     // standard deviations
constexpr double kSteeperBeyondChance = 2;              // standard deviations of the exponent of the cliff
constexpr double kEdge = 1.5;                           // factor below the line at which the cliff begins
constexpr double kEdgeBeyondChance = 2.5;
constexpr double kCliffWidth = 0.77, kPromiseWidth = 2.31;  // a third of a decade, a decade; in log f
constexpr Index kFewestBelow = 6, kFewestAfter = 4;

// log f, and the logarithm of the level without its bias, with its variance.
struct LogBins {
  std::vector<Index> bin;
  ArrayXd f, level, variance;
};

LogBins log_bins(const PsdEstimate& estimate) {
  const PsdBand band = usable_band(estimate, 0, kInfinity);
  if (band.bins.empty()) return {};
  const ArrayXd white = band.response.rowwise().sum();
  return {band.bins, band.frequency.log(), (band.psd / white).log() - band.log_bias, band.log_variance};
}

// Straight line with the variance of its extrapolation.
struct Promise {
  double f = 0, level = 0, slope = 0, variance = 0, slope_variance = 0;
  double at(double x) const { return level + slope * (x - f); }
  double variance_at(double x) const { return variance + slope_variance * (x - f) * (x - f); }
};

Promise line_through(const LogBins& bins, Index first, Index count) {
  const ArrayXd x = bins.f.segment(first, count), y = bins.level.segment(first, count);
  // A surface deviates from its line by about a tenth, however many ordinates a bin has.
  const ArrayXd w = (bins.variance.segment(first, count) + 0.01).inverse();
  Promise line;
  line.f = (w * x).sum() / w.sum(), line.level = (w * y).sum() / w.sum();
  const double spread = (w * (x - line.f).square()).sum();
  line.slope = spread > 0 ? (w * (x - line.f) * y).sum() / spread : 0;
  line.variance = 1 / w.sum(), line.slope_variance = spread > 0 ? 1 / spread : 0;
  return line;
}

// True if the bins from j on continue the lower half of the decade below bin `last`: the cliff ends a hump.
bool is_hump(const LogBins& bins, Index last, Index count, Index j) {
  const Index after = bins.f.size() - j, before = count / 2, first = last - count + 1;
  if (after < kFewestAfter) return false;
  const Promise back = line_through(bins, j, after);
  const double f = bins.f.segment(first, before).mean();
  const double level = bins.level.segment(first, before).mean();
  const double error =
      std::sqrt(back.variance_at(f) + bins.variance.segment(first, before).mean() / double(before));
  return std::abs(level - back.at(f)) < std::max(std::log(kGoesOn), kGoesOnWithinChance * error);
}

}  // namespace

std::optional<InstrumentEdge> instrument_edge(const PsdEstimate& estimate) {
  const LogBins bins = log_bins(estimate);
  const double steepest = estimate.kind == PsdTableKind::k1dOneSided ? kSteepestProfile : kSteepestSurface;
  const Index n = bins.f.size();
  for (Index last = kFewestBelow - 1; last + 1 < n; ++last) {
    Index count = 1;
    while (count <= last && bins.f[last] - bins.f[last - count] <= kPromiseWidth) ++count;
    if (count < kFewestBelow) continue;
    const Promise below = line_through(bins, last - count + 1, count);
    const auto missing = [&](Index j) { return below.at(bins.f[j]) - bins.level[j]; };
    const auto chance = [&](Index j) { return std::sqrt(bins.variance[j] + below.variance_at(bins.f[j])); };
    for (Index j = last + 1; j < n && bins.f[j] - bins.f[last] <= kCliffWidth; ++j) {
      const double exponent = (bins.level[last] - bins.level[j]) / (bins.f[j] - bins.f[last]);
      const double error = std::sqrt(bins.variance[last] + bins.variance[j]) / (bins.f[j] - bins.f[last]);
      if (missing(j) < std::max(std::log(kCliff), kBeyondChance * chance(j))) continue;
      if (exponent - kSteeperBeyondChance * error < steepest) continue;
      if (is_hump(bins, last, count, j)) continue;
      Index first = last + 1;
      while (first < j && missing(first) < std::max(std::log(kEdge), kEdgeBeyondChance * chance(first)))
        ++first;
      return InstrumentEdge{estimate.low[bins.bin[std::size_t(first)]], -below.slope, exponent};
    }
  }
  return std::nullopt;
}

}  // namespace aberfit::internal
