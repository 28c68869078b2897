#include "aberfit/method/prior_draws.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/random.h"

namespace aberfit {

double measured_spread(const LightPath& path, const CoefficientPrior& prior, std::uint64_t seed, int draws,
                       const RunContext& context) {
  std::vector<double> radius(static_cast<std::size_t>(draws));
  for (int d = 0; d < draws; ++d) {
    if (context.stopped()) return std::nan("");
    const std::uint64_t own = RandomStream(seed, "realisation-draws").bits(std::uint64_t(d));
    radius[std::size_t(d)] = focus_statistics(path, prior.colour(draw_white(prior.size(), own)),
                                              {EncircledEnergyRadius{}}, context.threads, nullptr)[0];
  }
  std::erase_if(radius, [](double r) { return !std::isfinite(r); });
  if (radius.size() < 2) return std::nan("");
  const Eigen::Map<const Eigen::ArrayXd> r(radius.data(), Eigen::Index(radius.size()));
  return std::sqrt((r - r.mean()).square().sum() / double(r.size() - 1)) / r.mean();
}

}  // namespace aberfit
