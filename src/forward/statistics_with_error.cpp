#include "aberfit/forward/statistics_with_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"
#include "aberfit/forward/forward_model.h"
#include "aberfit/forward/term_moments.h"
#include "aberfit/scene/quadrature_pupil.h"
#include "aberfit/theory/scattered_rays.h"
#include "moment_rays.h"

namespace aberfit {
using namespace internal;

namespace {

struct Traced {
  SurfaceField field;
  RayBundle nominal, rays;
};

Traced trace_terms(const LitMirror& lit, const TermSet& terms, const Eigen::VectorXd& coefficients,
                   const PupilSample& pupil, std::uint64_t scatter_seed, int threads) {
  Traced traced;
  SurfaceOperator(terms, pupil, {threads, {}, {}}).apply(coefficients, &traced.field);
  if (lit.scatter) add_scatter(*lit.scatter, pupil, scatter_seed, &traced.field);
  traced.nominal = trace_nominal(lit.mirror, pupil);
  traced.rays = trace(lit.mirror, pupil, traced.field);
  return traced;
}

Eigen::VectorXd statistics_of(const LitMirror& lit, const Traced& traced,
                              const std::vector<Statistic>& statistics, int threads, Warnings* warnings) {
  return evaluate_exact({traced.rays, traced.nominal, traced.field.height, lit.centre,
                         lit.scatter ? lit.scatter->rms_height() : 0},
                        statistics, threads, warnings);
}

// The scrambles as one pupil with all their rays.
Traced joined(std::vector<Traced> parts) {
  const auto n = Eigen::Index(parts.size());
  const auto append = [n](Eigen::ArrayXd& whole, const Eigen::ArrayXd& part, Eigen::Index k) {
    if (k == 0) whole.resize(n * part.size());
    whole.segment(k * part.size(), part.size()) = part;
  };
  const auto append_bundle = [&](RayBundle& whole, const RayBundle& part, Eigen::Index k) {
    for (const auto array : {&RayBundle::x, &RayBundle::y, &RayBundle::tx, &RayBundle::ty})
      append(whole.*array, part.*array, k);
    append(whole.weight, part.weight / double(n), k);
    whole.lost += part.lost;
  };
  Traced whole;
  for (Eigen::Index k = 0; k < n; ++k) {
    Traced part = std::move(parts[std::size_t(k)]);
    append(whole.field.height, part.field.height, k);
    append_bundle(whole.nominal, part.nominal, k);
    append_bundle(whole.rays, part.rays, k);
  }
  return whole;
}

// Replaces the moments of the scrambles by those from points that are exact for the order of the surface,
// which have no sampling error. The mean angle of terms and scatter together stays with the rays.
void set_moments(const LitMirror& lit, const TermSet& terms, const Eigen::VectorXd& coefficients,
                 const std::vector<Statistic>& statistics, int threads, FreshStatistics* fresh) {
  const std::optional<Aperture> clear = without_margin(lit.aperture);
  const SplitStatistics split(statistics);
  if (!clear || split.geometric.empty()) return;
  const std::unique_ptr<MomentRays> moments =
      make_moment_rays(lit.mirror, *clear, terms, split.geometric, threads);
  if (!moments) return;
  moments->move_to(coefficients);
  const Eigen::VectorXd values = moments->rays().exact(nullptr);
  for (std::size_t j = 0; j < split.geometric.size(); ++j) {
    const auto at = Eigen::Index(split.geometric_place[j]);
    if (!std::isfinite(values[Eigen::Index(j)])) continue;
    if (lit.scatter && std::holds_alternative<ScatterMean>(split.geometric[j])) continue;
    fresh->value[at] = with_scatter(lit.scatter.get(), split.geometric[j], values[Eigen::Index(j)]);
    fresh->standard_error[at] = 0;
  }
}

// Three grids coarser by kCoarserGrid or a little less, which differ in the cells that straddle the edge.
// Pitches are in units of the judging grid's, shifts in grid cells.
struct CoarseGrid {
  double pitch;
  std::array<double, 2> shift;
};
constexpr CoarseGrid kCoarseGrids[] = {
    {kCoarserGrid, {0.0, 0.0}}, {kCoarserGrid, {0.25, -0.35}}, {0.93 * kCoarserGrid, {-0.4, 0.15}}};

// Bound over the largest difference. An error that falls as pitch^2 with one sign is 1/(1.37^2 - 1) = 1.14 of
// its difference to the coarser grid; one with changing sign is at most half of the largest difference. The
// rest covers the chance that three differences are small: 1.3 gives 95 % coverage in 11 of 12 scenes
// (circles, annulus, rectangle, polygon, f/2 to f/7, g 0.4 to 4; tests/forward).
constexpr double kBoundOverDifference = 1.5;
// Aliasing falls with the pitch, so the coarser grids alias at least twice as much as the judging grid, and
// 1.5 times the difference covers it.
constexpr double kAliasedForTheError = kMostAliasedBeforeAFiner;

Eigen::VectorXd by_waves(const LitMirror& lit, const FreshPupil& wanted, const PupilSample& pupil,
                         const TermSet& terms, const Eigen::VectorXd& coefficients,
                         const std::vector<Statistic>& statistics, double aliased_limit, int threads,
                         DiffractionWorkspace* workspace, Warnings* warnings) {
  const SurfaceOperator surface(terms, pupil, focus_operator(FocusModel::kWaves, threads));
  LightPath path{lit.mirror, pupil, surface, FocusModel::kWaves, lit.wavelength, &lit.aperture, lit.centre};
  path.aliased_limit = aliased_limit;
  path.workspace = workspace;
  path.scatter = lit.scatter;
  path.single_precision = wanted.single_precision;
  return focus_statistics(path, coefficients, statistics, threads, warnings);
}

FreshStatistics fresh_by_waves(const LitMirror& lit, const FreshPupil& wanted, const TermSet& terms,
                               const Eigen::VectorXd& coefficients, const std::vector<Statistic>& statistics,
                               int threads, Warnings* warnings) {
  const double pitch = wanted.pitch;
  const auto pupil = [&](double of_pitch, std::array<double, 2> shift) {
    return diffraction_pupil(lit.aperture, lit.mirror.focal_length, of_pitch, shift).sample;
  };
  // Rings are searched on a coarse grid, and then followed.
  DiffractionWorkspace workspace;
  workspace.follow_rings();
  std::vector<Statistic> rings = statistics;
  std::erase_if(rings, [](const Statistic& s) { return !std::holds_alternative<RingFwhm>(s); });
  if (!rings.empty())
    by_waves(lit, wanted, pupil(kSearchGrid * pitch, {0, 0}), terms, coefficients, rings, kAliasedForTheError,
             threads, &workspace, nullptr);
  FreshStatistics fresh;
  fresh.errors_are_bounds = true;
  std::vector<Eigen::VectorXd> there;
  for (const CoarseGrid& grid : kCoarseGrids) {
    there.push_back(by_waves(lit, wanted, pupil(grid.pitch * pitch, grid.shift), terms, coefficients,
                             statistics, kAliasedForTheError, threads, &workspace, nullptr));
    if (!wanted.all_or_nothing || there.back().allFinite()) continue;
    fresh.rays = pupil(pitch, {0, 0}).size();
    fresh.value = fresh.standard_error = Eigen::VectorXd::Constant(there.back().size(), std::nan(""));
    return fresh;
  }
  const PupilSample fine = pupil(pitch, {0, 0});  // made late because millions of cells take a GB
  fresh.rays = fine.size();
  fresh.value =
      by_waves(lit, wanted, fine, terms, coefficients, statistics,
               wanted.all_or_nothing ? kAliasedForTheError : kMostAliased, threads, &workspace, warnings);
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(fresh.value.size());
  for (const Eigen::VectorXd& values : there)
    for (Eigen::Index k = 0; k < largest.size(); ++k) {
      // NaN stays: where one grid has no value, the error is not known.
      const double difference = std::abs(fresh.value[k] - values[k]);
      if (!(difference <= largest[k])) largest[k] = std::isnan(largest[k]) ? largest[k] : difference;
    }
  fresh.standard_error = kBoundOverDifference * largest;
  return fresh;
}

FreshStatistics fresh_by_rays(const LitMirror& lit, const FreshPupil& wanted, const TermSet& terms,
                              const Eigen::VectorXd& coefficients, const std::vector<Statistic>& statistics,
                              int threads, Warnings* warnings) {
  const RandomStream seeds(wanted.seed, "fresh-rays");
  const std::int64_t per_scramble =
      std::clamp<std::int64_t>(wanted.rays, kScrambles, kMostFreshRays) / kScrambles;
  std::vector<Traced> parts(kScrambles);
  Eigen::MatrixXd values(Eigen::Index(statistics.size()), kScrambles);
  parallel_for(kScrambles, threads, [&](std::size_t k) {
    const std::uint64_t seed = seeds.bits(k);
    const PupilSample pupil = make_pupil(lit.aperture, {PupilLayout::kSobol, per_scramble, seed});
    parts[k] = trace_terms(lit, terms, coefficients, pupil, seed, 1);
    values.col(Eigen::Index(k)) = statistics_of(lit, parts[k], statistics, 1, nullptr);
  });
  const Traced traced = joined(std::move(parts));
  FreshStatistics fresh;
  fresh.rays = traced.rays.size();
  fresh.lost = traced.rays.lost;
  fresh.value = statistics_of(lit, traced, statistics, threads, warnings);
  fresh.standard_error = standard_error_of_mean(values);
  fresh.degrees_of_freedom = kScrambles - 1;
  set_moments(lit, terms, coefficients, statistics, threads, &fresh);
  return fresh;
}

}  // namespace

Eigen::VectorXd standard_error_of_mean(const Eigen::MatrixXd& samples) {
  const double count = double(samples.cols());
  const Eigen::VectorXd mean = samples.rowwise().mean();
  return ((samples.colwise() - mean).rowwise().squaredNorm() / (count * (count - 1))).cwiseSqrt();
}

FreshStatistics statistics_with_error(const LitMirror& lit, const FreshPupil& pupil, const TermSet& terms,
                                      const Eigen::VectorXd& coefficients,
                                      const std::vector<Statistic>& statistics, int threads,
                                      Warnings* warnings) {
  FreshStatistics fresh = pupil.model == FocusModel::kWaves
                              ? fresh_by_waves(lit, pupil, terms, coefficients, statistics, threads, warnings)
                              : fresh_by_rays(lit, pupil, terms, coefficients, statistics, threads, warnings);
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    double& error = fresh.standard_error[Eigen::Index(k)];
    if (std::holds_alternative<ScatterMean>(statistics[k]))
      error = std::max(error, kMeanAngleError * std::abs(fresh.value[Eigen::Index(k)]));
  }
  return fresh;
}

}  // namespace aberfit
