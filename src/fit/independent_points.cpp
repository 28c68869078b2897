#include "independent_points.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "aberfit/core/parallel.h"

namespace aberfit::internal {
namespace {

using Eigen::Index;

struct Lag {
  Index rows = 0, columns = 0;  // rows >= 0: the other half plane has the same products
  double angle = 0;
};

// Number of lags per ring of the half plane; the others of a ring are assumed to be alike.
constexpr std::size_t kDirections = 24;

// Lags of the half plane at a distance that rounds to `ring` units, by angle.
std::vector<Lag> lags_of(int ring, double unit, double pitch_x, double pitch_y) {
  const Index rows = Index((ring + 1) * unit / pitch_y), columns = Index((ring + 1) * unit / pitch_x);
  std::vector<Lag> lags;
  for (Index k = 0; k <= rows; ++k)
    for (Index l = k == 0 ? 1 : -columns; l <= columns; ++l) {
      const double x = double(l) * pitch_x, y = double(k) * pitch_y;
      if (std::lround(std::hypot(x, y) / unit) == ring) lags.push_back({k, l, std::atan2(y, x)});
    }
  std::sort(lags.begin(), lags.end(), [](const Lag& a, const Lag& b) { return a.angle < b.angle; });
  return lags;
}

double sum_of_products(const Grid& residual, const Lag& lag) {
  const Index width = residual.cols() - std::abs(lag.columns);
  if (width <= 0) return 0;
  const Index here = std::max<Index>(0, -lag.columns), there = std::max<Index>(0, lag.columns);
  double sum = 0;
  for (Index i = 0; i + lag.rows < residual.rows(); ++i)
    sum += (residual.row(i).segment(here, width) * residual.row(i + lag.rows).segment(there, width)).sum();
  return sum;
}

}  // namespace

double correlated_neighbours(const Grid& residual, double pitch_x, double pitch_y, int threads) {
  const double squares = residual.square().sum();
  if (!(squares > 0)) return 1;
  const double unit = std::max(pitch_x, pitch_y);
  const int last =
      int(0.5 * std::min(pitch_x * double(residual.cols()), pitch_y * double(residual.rows())) / unit);
  double total = 1;
  for (int ring = 0; ring <= last; ++ring) {
    const std::vector<Lag> lags = lags_of(ring, unit, pitch_x, pitch_y);
    if (lags.empty()) continue;  // ring 0, unless one pitch is at least twice the other
    const std::size_t looked_at = std::min(lags.size(), kDirections);
    std::vector<double> products(looked_at);
    parallel_for(looked_at, threads, [&](std::size_t i) {
      products[i] = sum_of_products(residual, lags[i * lags.size() / looked_at]);
    });
    double sum = 0;
    for (const double product : products) sum += product;
    if (!(sum > 0)) break;
    total += 2 * sum * double(lags.size()) / (double(looked_at) * squares);
  }
  return total;
}

}  // namespace aberfit::internal
