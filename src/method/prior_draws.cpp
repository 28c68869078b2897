#include "aberfit/method/prior_draws.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"

namespace aberfit {
namespace {

constexpr double kZoneEdges[] = {0, 0.25, 0.5, 0.75, 1};
constexpr std::size_t kZones = 4;

}  // namespace

std::vector<ZoneSlope> zone_slopes(const Task& task, const TermSet& terms, const CoefficientPrior& prior,
                                   const Eigen::VectorXd& coefficients, int threads) {
  // Squared slopes of degree 2 n: a polar rule of n rings and 2 n spokes is exact over the disc, twice that
  // is close enough per zone.
  const int order = terms.zernike.empty() ? 0 : terms.zernike.back().n;
  const std::int64_t points = std::clamp<std::int64_t>(4 * std::int64_t(order) * order, 4096, 65536);
  const bool round = task.aperture.index() < 2;
  const PupilSample pupil =
      make_pupil(task.aperture, {round ? PupilLayout::kPolar : PupilLayout::kSobol, points, 1});
  const SurfaceOperator surface(terms, pupil, {});
  const double radius = aperture_radius(task.aperture);
  std::vector<std::size_t> zone_of(std::size_t(pupil.size()));
  for (std::size_t i = 0; i < zone_of.size(); ++i) {
    const double rho = std::hypot(pupil.x[Eigen::Index(i)], pupil.y[Eigen::Index(i)]) / radius;
    zone_of[i] = std::min<std::size_t>(kZones - 1, std::size_t(rho * kZones));
  }
  const auto ratios = [&](const Eigen::VectorXd& c) {
    SurfaceField field;
    surface.apply(c, &field);
    double sum[kZones] = {}, weight[kZones] = {}, total = 0, total_weight = 0;
    for (std::size_t i = 0; i < zone_of.size(); ++i) {
      const auto k = Eigen::Index(i);
      const double s2 = field.slope_x[k] * field.slope_x[k] + field.slope_y[k] * field.slope_y[k];
      sum[zone_of[i]] += pupil.weight[k] * s2;
      weight[zone_of[i]] += pupil.weight[k];
      total += pupil.weight[k] * s2;
      total_weight += pupil.weight[k];
    }
    std::array<double, kZones> ratio{};
    for (std::size_t z = 0; z < kZones; ++z)
      ratio[z] = weight[z] > 0 ? std::sqrt(sum[z] / weight[z] / (total / total_weight)) : std::nan("");
    return ratio;
  };
  std::vector<std::array<double, kZones>> draws(kZoneDraws);
  parallel_for(kZoneDraws, threads, [&](std::size_t d) {
    const std::uint64_t seed = RandomStream(task.fit.seed, "zone-draws").bits(d);
    draws[d] = ratios(prior.colour(draw_white(prior.size(), seed)));
  });
  const auto own = ratios(coefficients);
  std::vector<ZoneSlope> zones;
  for (std::size_t z = 0; z < kZones; ++z) {
    if (!std::isfinite(draws[0][z])) continue;  // inside the hole of an annulus: no such zone
    std::vector<double> values;
    for (const auto& draw : draws) values.push_back(draw[z]);
    std::sort(values.begin(), values.end());
    const auto quantile = [&](double p) {
      return values[std::size_t(std::lround(p * double(kZoneDraws - 1)))];
    };
    zones.push_back({kZoneEdges[z], kZoneEdges[z + 1], own[z], quantile(0.005), quantile(0.995)});
  }
  return zones;
}

}  // namespace aberfit
