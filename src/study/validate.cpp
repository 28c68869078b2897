#include "validate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"

namespace aberfit {
namespace {

// Everything the statistics need of one pupil.
struct Traced {
  SurfaceField field;
  RayBundle nominal, rays;
};

Traced trace_terms(const Study& study, const TermSet& terms, const Eigen::VectorXd& coefficients,
                   const PupilSample& pupil, int threads) {
  Traced traced;
  SurfaceOperator(terms, pupil.x, pupil.y, threads).apply(coefficients, &traced.field);
  traced.nominal = trace_nominal(study.mirror, pupil);
  traced.rays = trace(study.mirror, pupil, traced.field);
  return traced;
}

Eigen::VectorXd statistics_of(const Study& study, const Traced& traced,
                              const std::vector<Statistic>& statistics, int threads, Warnings* warnings) {
  return evaluate_exact({traced.rays, traced.nominal, traced.field.height, study.trace.centre}, statistics,
                        threads, warnings);
}

constexpr double kZoneEdges[] = {0, 0.25, 0.5, 0.75, 1};
constexpr std::size_t kZones = 4;
constexpr std::size_t kDraws = 1000;

}  // namespace

FreshStatistics evaluate_fresh(const Study& study, const TermSet& terms, const Eigen::VectorXd& coefficients,
                               const std::vector<Statistic>& statistics, std::int64_t rays, int threads,
                               Warnings* warnings) {
  const RandomStream seeds(study.trace.pupil.seed, "fresh-rays");
  const std::int64_t per_scramble = std::max<std::int64_t>(1, rays / kScrambles);
  std::vector<PupilSample> parts(kScrambles);
  Eigen::MatrixXd values(Eigen::Index(statistics.size()), kScrambles);
  parallel_for(kScrambles, threads, [&](std::size_t k) {
    parts[k] = make_pupil(study.aperture, {PupilLayout::kSobol, per_scramble, seeds.bits(k)});
    values.col(Eigen::Index(k)) =
        statistics_of(study, trace_terms(study, terms, coefficients, parts[k], 1), statistics, 1, nullptr);
  });
  const Eigen::Index n = parts[0].size();
  PupilSample all{Eigen::ArrayXd(kScrambles * n), Eigen::ArrayXd(kScrambles * n),
                  Eigen::ArrayXd::Constant(kScrambles * n, 1.0 / double(kScrambles * n)),
                  PupilLayout::kSobol};
  for (int k = 0; k < kScrambles; ++k) {
    all.x.segment(k * n, n) = parts[std::size_t(k)].x;
    all.y.segment(k * n, n) = parts[std::size_t(k)].y;
  }
  const Traced traced = trace_terms(study, terms, coefficients, all, threads);
  FreshStatistics fresh;
  fresh.rays = all.size();
  fresh.lost = traced.rays.lost;
  fresh.value = statistics_of(study, traced, statistics, threads, warnings);
  const Eigen::VectorXd mean = values.rowwise().mean();
  fresh.standard_error =
      ((values.colwise() - mean).rowwise().squaredNorm() / (kScrambles * (kScrambles - 1.0))).cwiseSqrt();
  return fresh;
}

std::vector<ZoneSlope> zone_slopes(const Study& study, const TermSet& terms, const CoefficientPrior& prior,
                                   const Eigen::VectorXd& coefficients, int threads) {
  // Squared slopes of degree 2 n: a polar rule of n rings and 2 n spokes is exact over the disc, twice that
  // is close enough per zone.
  const int order = terms.zernike.empty() ? 0 : terms.zernike.back().n;
  const std::int64_t points = std::clamp<std::int64_t>(4 * std::int64_t(order) * order, 4096, 65536);
  const bool round = study.aperture.index() < 2;
  const PupilSample pupil =
      make_pupil(study.aperture, {round ? PupilLayout::kPolar : PupilLayout::kSobol, points, 1});
  const SurfaceOperator surface(terms, pupil.x, pupil.y, 1);
  const double radius = aperture_radius(study.aperture);
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
  std::vector<std::array<double, kZones>> draws(kDraws);
  parallel_for(kDraws, threads, [&](std::size_t d) {
    const std::uint64_t seed = RandomStream(study.fit.seed, "zone-draws").bits(d);
    draws[d] = ratios(prior.colour(draw_white(prior.size(), seed)));
  });
  const auto own = ratios(coefficients);
  std::vector<ZoneSlope> zones;
  for (std::size_t z = 0; z < kZones; ++z) {
    if (!std::isfinite(draws[0][z])) continue;  // inside the hole of an annulus: no such zone
    std::vector<double> values;
    for (const auto& draw : draws) values.push_back(draw[z]);
    std::sort(values.begin(), values.end());
    const auto quantile = [&](double p) { return values[std::size_t(p * double(kDraws - 1) + 0.5)]; };
    zones.push_back({kZoneEdges[z], kZoneEdges[z + 1], own[z], quantile(0.005), quantile(0.995)});
  }
  return zones;
}

}  // namespace aberfit
