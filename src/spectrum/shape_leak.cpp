#include "shape_leak.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "detrend_basis.h"

namespace aberfit::internal {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr int kMoreDegrees = 4;
constexpr double kSurely = 8;  // frequency steps above which further detrending keeps the power of roughness
constexpr double kKept = 0.1;  // fraction of a bin's response that further degrees may remove
constexpr double kLeaks = 2;   // factor by which a leaking bin falls
constexpr double kSuspicious = 1.5;
constexpr double kFalls = 4;            // the same for a bin below kSurely
constexpr double kAboveLine = 3;        // factor of such a bin over the line
constexpr double kChanceOfRise = 1e-5;  // and its probability by chance
constexpr double kErrors = 3;           // errors of the line that count as chance
constexpr double kLowest = 1.5;         // frequency steps; fits use no bin below
constexpr double kClean = 0.14;         // largest |log| of the change of a bin without leakage
constexpr Index kCleanBins = 2;         // number in a row
constexpr Index kFewestAbove = 6;
constexpr double kLineDecade = 2.31;  // in log f

Index first_sure(const PsdEstimate& estimate) {
  Index b = 0;
  while (b < estimate.psd.size() && estimate.frequency[b] < kSurely * estimate.resolution) ++b;
  return b;
}

// Power law through the decade of bins from `first` on, log level = at + slope u, u = log(f/f_first), with
// the error of its extrapolation to the bins below.
struct LeakFreeLine {
  double at = 0, slope = 0;
  double dof = 0, mean = 0, spread = 0;  // mean and spread of u, weighted by degrees of freedom

  double error_at(double u) const { return std::sqrt(2 / dof + 2 * (u - mean) * (u - mean) / spread); }
};
LeakFreeLine line_from(const PsdEstimate& estimate, const ArrayXd& psd, Index first) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (Index b = first; b < psd.size(); ++b) {
    const double u = std::log(estimate.frequency[b] / estimate.frequency[first]);
    if (u > kLineDecade) break;
    if (!(psd[b] > 0)) continue;
    const double v = std::log(psd[b] / estimate.response.row(b).sum()), w = estimate.dof[b];
    n += w, x += w * u, y += w * v, xx += w * u * u, xy += w * u * v;
  }
  const double spread = xx - x * x / n;
  if (!(spread > 0)) return {};
  const double slope = (xy - x * y / n) / spread;
  return {(y - slope * x) / n, slope, n, x / n, spread};
}

// Expectations of the bins if S falls as f^slope, with S = 1 at `from`.
ArrayXd expected(const PsdEstimate& estimate, double slope, double from) {
  const ArrayXd f = estimate.node_frequency / from;
  const ArrayXd s = (f > 0).select(f.max(1e-300).pow(slope), 0.0);
  return (estimate.response * s.matrix()).array();
}

// Bounds the probability that a chi-squared level of `dof` exceeds `factor` times its mean (Chernoff).
double chance_of(double factor, double dof) {
  return factor <= 1 ? 1 : std::exp(-0.5 * dof * (factor - 1 - std::log(factor)));
}

std::vector<char> above_the_line(const PsdEstimate& estimate, const LeakFreeLine& line, Index first) {
  std::vector<char> above(std::size_t(estimate.psd.size()), 0);
  if (!(line.spread > 0)) return above;
  const ArrayXd promise = std::exp(line.at) * expected(estimate, line.slope, estimate.frequency[first]);
  for (Index b = 0; b < first; ++b) {
    if (estimate.frequency[b] < kLowest * estimate.resolution) continue;
    const double error = line.error_at(std::log(estimate.frequency[b] / estimate.frequency[first]));
    const double factor = estimate.psd[b] / (promise[b] * std::exp(kErrors * error));
    above[std::size_t(b)] = factor > kAboveLine && chance_of(factor, estimate.dof[b]) < kChanceOfRise;
  }
  return above;
}

}  // namespace

DetrendOptions detrended_further(const DetrendOptions& options, bool profile) {
  return {DetrendShape::kPolynomial, std::max(0, polynomial_degree(options, profile)) + kMoreDegrees};
}

bool may_leak(const PsdEstimate& estimate, const ArrayXd& further) {
  const Index first = first_sure(estimate), n = estimate.psd.size();
  if (n - first < kFewestAbove) return false;
  const std::vector<char> above = above_the_line(estimate, line_from(estimate, further, first), first);
  for (Index b = 0; b < n; ++b)
    if (above[std::size_t(b)] || (b >= first && estimate.psd[b] > kSuspicious * further[b])) return true;
  return false;
}

std::optional<ShapeLeak> shape_leak(const PsdEstimate& estimate, const PsdEstimate& further) {
  const Index first = first_sure(estimate), n = estimate.psd.size();
  if (n - first < kFewestAbove || further.psd.size() != n) return std::nullopt;
  const LeakFreeLine line = line_from(further, further.psd, first);
  const double from = estimate.frequency[first];
  const ArrayXd kept = expected(further, line.slope, from) / expected(estimate, line.slope, from);
  const ArrayXd fall = estimate.psd / further.psd * kept;
  const std::vector<char> above = above_the_line(estimate, line, first);
  Index last = -1;
  for (Index b = 0; b < n; ++b) {
    if (b >= first && std::abs(kept[b] - 1) < kKept && fall[b] > kLeaks) last = b;
    if (above[std::size_t(b)] && fall[b] > kFalls) last = b;
  }
  if (last < 0) return std::nullopt;
  for (Index b = last + 1; b < n && b <= last + kCleanBins; ++b)
    if (std::abs(std::log(fall[b])) > kClean) last = b;
  return ShapeLeak{estimate.high[last], fall.head(last + 1).maxCoeff(), n - 1 - last < kFewestAbove};
}

}  // namespace aberfit::internal
