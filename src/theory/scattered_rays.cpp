#include "aberfit/theory/scattered_rays.h"

#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "aberfit/core/random.h"

namespace aberfit {
namespace {

double normal_quantile(double share) { return -std::sqrt(2.0) * boost::math::erfc_inv(2 * share); }

// Index of the Sobol point that each ray takes. Points of a structured pupil follow each other, so neighbours
// get even slopes in order. A Sobol pupil has the same digits as the slopes, so its order is random.
std::vector<Eigen::Index> deal(const PupilSample& pupil, std::uint64_t seed) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(pupil.size()));
  std::iota(order.begin(), order.end(), Eigen::Index(0));
  if (!std::holds_alternative<std::monostate>(pupil.structure)) return order;
  const RandomStream stream(seed, "scatter-deal");
  for (std::size_t k = order.size(); k > 1; --k)
    std::swap(order[k - 1], order[std::size_t(stream.uniform(k) * double(k))]);
  return order;
}

}  // namespace

void add_scatter(const MeanScatter& scatter, const PupilSample& pupil, std::uint64_t seed,
                 SurfaceField* field) {
  const Eigen::Index n = pupil.size();
  if (field->size() == 0) {
    field->resize(n);
    field->height.setZero();
    field->slope_x.setZero();
    field->slope_y.setZero();
  }
  const Eigen::Array2Xd even = scrambled_sobol(n, RandomStream(seed, "scatter-slopes").bits(0));
  const std::vector<Eigen::Index> order = deal(pupil, seed);
  const double slope = scatter.rms_slope_per_axis();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index k = order[std::size_t(i)];
    field->slope_x[i] += slope * normal_quantile(even(0, k));
    field->slope_y[i] += slope * normal_quantile(even(1, k));
  }
}

}  // namespace aberfit
