#include "verify_ensemble.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"
#include "aberfit/forward/forward_model.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/theory/ray_perturbation.h"
#include "task_surface.h"

namespace aberfit {
using namespace internal;

namespace {

// Rays of many draws one behind the other, with the directions of their nominal rays.
struct Gathered {
  RayBundle rays, nominal;

  explicit Gathered(Eigen::Index size) {
    for (const auto part : {&RayBundle::x, &RayBundle::y, &RayBundle::tx, &RayBundle::ty, &RayBundle::weight})
      (rays.*part).resize(size);
    nominal.tx.resize(size);
    nominal.ty.resize(size);
  }
  void put(Eigen::Index at, const RayBundle& from, const RayBundle& ideal, double share) {
    for (const auto part : {&RayBundle::x, &RayBundle::y, &RayBundle::tx, &RayBundle::ty})
      (rays.*part).segment(at, from.size()) = from.*part;
    rays.weight.segment(at, from.size()) = share * from.weight;
    nominal.tx.segment(at, from.size()) = ideal.tx;
    nominal.ty.segment(at, from.size()) = ideal.ty;
  }
};

Eigen::VectorXd statistics_of(const Gathered& light, Centre centre, const std::vector<Statistic>& statistics,
                              int threads) {
  static const Eigen::ArrayXd kNoHeight;
  return evaluate_exact({light.rays, light.nominal, kNoHeight, centre}, statistics, threads);
}

// Draws share the pupil of their group, so that law::kGroups times as many points see the aperture; what one
// draw misses between its points is noise that the mean over draws averages.
// Mean over all and its standard error from groups that are each evaluated alone. `light` fills the rays of
// a group from the given place on.
template <typename Light>
EnsembleMean mean_of_groups(const Task& task, int draws, const std::vector<Statistic>& statistics,
                            int threads, const Light& light) {
  const int per_group = draws / law::kGroups;
  const Eigen::Index group_rays = Eigen::Index(per_group) * law::kRaysOfDraw;
  Gathered all(group_rays * law::kGroups);
  Eigen::MatrixXd values(Eigen::Index(statistics.size()), law::kGroups);
  parallel_for(law::kGroups, threads, [&](std::size_t g) {
    const std::uint64_t seed = RandomStream(task.trace.pupil.seed, "ensemble-pupils").bits(g);
    const PupilSample pupil = make_pupil(task.aperture, {PupilLayout::kSobol, law::kRaysOfDraw, seed});
    Gathered group(group_rays);
    light(g, per_group, pupil, trace_nominal(task.mirror, pupil), &group);
    values.col(Eigen::Index(g)) = statistics_of(group, task.trace.centre, statistics, 1);
    all.put(Eigen::Index(g) * group_rays, group.rays, group.nominal, 1.0 / law::kGroups);
  });
  EnsembleMean mean;
  mean.value = statistics_of(all, task.trace.centre, statistics, threads);
  mean.standard_error = standard_error_of_mean(values);
  return mean;
}

Eigen::VectorXd drawn(const Ensemble& ensemble, std::uint64_t draw) {
  const std::uint64_t seed = RandomStream(ensemble.task.fit.seed, "ensemble-draws").bits(draw);
  return ensemble.prior.colour(draw_white(ensemble.prior.size(), seed));
}

// A share of light that a metric is made of: theory's value, and the metric once the truth is known.
struct LightRow {
  std::string name;
  double fraction = 0, radius = 0, slope = 0;  // of an EE radius
  double width = 0;                            // of the ring, by theory
  double rise = 0, fall = 0;                   // |dN/dz| at its two ends over N at its peak [1/m]
  std::vector<std::size_t> shares;  // which of the shares asked for: one, or below, in and above the peak
};
struct LightPlan {
  std::vector<LightRow> rows;
  std::vector<Statistic> shares;
  std::vector<Target> extent;  // for the pitch of the grid

  std::size_t add(double radius, double dz) {
    shares.push_back(RingThrough{radius, dz});
    return shares.size() - 1;
  }
};

LightPlan plan_light(const GeneralisedHarveyShack& ghs, const std::vector<Statistic>& statistics) {
  LightPlan plan;
  for (const Statistic& statistic : statistics) {
    LightRow row{statistic_name(statistic), 0, 0, 0, 0, 0, 0, {}};
    if (const auto* ee = std::get_if<EncircledEnergyRadius>(&statistic)) {
      const MeanSpot spot = ghs.at_plane(ee->dz);
      row.fraction = ee->fraction;
      row.radius = spot.encircled_energy_radius(ee->fraction);
      if (!std::isfinite(row.radius)) continue;
      row.slope = spot.encircled_energy_slope(row.radius);
      row.shares = {plan.add(row.radius, ee->dz)};
      plan.extent.push_back({statistic, row.radius, 0, 0});
    } else if (const auto* ring = std::get_if<RingFwhm>(&statistic);
               ring && !ring->ring_radius && ring->ring_fraction == 0.9) {
      const double radius = ghs.encircled_energy_radius(ring->ring_fraction, 0);
      const GeneralisedHarveyShack::RingPlanes planes = ghs.ring_planes(radius);
      row.width = planes.upper - planes.lower;
      if (!std::isfinite(row.width)) continue;
      const double step = 0.01 * row.width, most = ghs.encircled_energy(radius, planes.peak);
      const auto steepness = [&](double plane) {
        return std::abs(ghs.encircled_energy(radius, plane - step) -
                        ghs.encircled_energy(radius, plane + step)) /
               (2 * step * most);
      };
      row.rise = steepness(planes.lower);
      row.fall = steepness(planes.upper);
      row.shares = {plan.add(radius, planes.lower), plan.add(radius, planes.peak),
                    plan.add(radius, planes.upper)};
      plan.extent.push_back({statistic, row.width, 0, 0});
    } else {
      continue;
    }
    plan.rows.push_back(row);
  }
  return plan;
}

// Quantile of Student's t over the normal one: what a standard error from groups is widened by before a test
// that takes it for known.
double student_widening(double confidence) {
  return student_quantile(confidence, law::kGroups - 1) / student_quantile(confidence, kInfinity);
}

// The metric from the mean shares and what groups of draws gave.
EquivalenceMetric light_metric(const LightRow& row, const EnsembleMean& shares, const Eigen::MatrixXd& groups,
                               const EquivalenceSpec& test) {
  const auto at = [&](std::size_t k) { return Eigen::Index(row.shares[k]); };
  const bool drawn = groups.cols() > 1;
  const double wider = drawn ? student_widening(test.confidence) : 1;
  if (row.shares.size() == 1) {
    EquivalenceMetric metric =
        share_metric(row.name, row.fraction, row.radius, row.slope, shares.value[at(0)],
                     wider * shares.standard_error[at(0)], test.margin, test.confidence);
    metric.standard_error /= wider;
    return metric;
  }
  // How far the light at theory's two ends is above half of that at its peak, as a change of the width:
  // each end moves by its excess over its slope.
  const auto width_of = [&](double before, double peak, double behind) {
    return row.width + (before / peak - 0.5) / row.rise + (behind / peak - 0.5) / row.fall;
  };
  const double width = width_of(shares.value[at(0)], shares.value[at(1)], shares.value[at(2)]);
  if (!drawn)
    return tost(row.name, false, row.width, 0, width,
                shares.standard_error[at(1)] / std::min(row.rise, row.fall), test.margin, test.confidence);
  Eigen::ArrayXd widths(groups.cols());
  for (Eigen::Index g = 0; g < groups.cols(); ++g)
    widths[g] = width_of(groups(at(0), g), groups(at(1), g), groups(at(2), g));
  const double n = double(groups.cols());
  return tost_of_groups(row.name, row.width, 0, width,
                        std::sqrt((widths - widths.mean()).square().sum() / (n * (n - 1))), test);
}

struct WaveShares {
  EnsembleMean mean;
  Eigen::MatrixXd groups;  // shares by groups; empty for a given surface
};

WaveShares shares_of_draws(const Ensemble& ensemble, const LightPlan& plan, double pitch, int draws,
                           int threads) {
  const Task& task = ensemble.task;
  const PupilSample pupil = focus_pupil(task, FocusModel::kWaves, task.trace.pupil, pitch);
  const SurfaceOperator surface(ensemble.terms, pupil, focus_operator(FocusModel::kWaves, 1));
  const LightPath path{task.mirror,     pupil,          surface,          FocusModel::kWaves,
                       task.wavelength, &task.aperture, task.trace.centre};
  WaveShares shares;
  shares.groups = Eigen::MatrixXd::Zero(Eigen::Index(plan.shares.size()), law::kGroups);
  const int per_group = draws / law::kGroups;
  parallel_for(law::kGroups, threads, [&](std::size_t g) {
    const auto model = make_forward_model(path, plan.shares, 1);
    for (int d = 0; d < per_group; ++d) {
      model->move_to(drawn(ensemble, g * std::uint64_t(per_group) + std::uint64_t(d)));
      shares.groups.col(Eigen::Index(g)) += model->exact(nullptr) / per_group;
    }
  });
  shares.mean.value = shares.groups.rowwise().mean();
  shares.mean.standard_error = standard_error_of_mean(shares.groups);
  return shares;
}

}  // namespace

namespace internal {

EquivalenceMetric tost_of_groups(const std::string& name, double target, double target_error, double model,
                                 double model_error, const EquivalenceSpec& test) {
  const double wider = student_widening(test.confidence);
  EquivalenceMetric metric = tost(name, false, target, wider * target_error, model, wider * model_error,
                                  test.margin, test.confidence);
  metric.standard_error /= wider;
  return metric;
}

EnsembleMean ensemble_by_rays(const Ensemble& ensemble, const std::vector<Statistic>& statistics,
                              int threads) {
  const Task& task = ensemble.task;
  return mean_of_groups(
      task, ensemble.draws, statistics, threads,
      [&](std::size_t g, int count, const PupilSample& pupil, const RayBundle& nominal, Gathered* group) {
        const SurfaceOperator surface(ensemble.terms, pupil, {});
        SurfaceField field;
        for (int d = 0; d < count; ++d) {
          const Eigen::VectorXd c = drawn(ensemble, g * std::uint64_t(count) + std::uint64_t(d));
          if (task.trace.central_difference_step)
            field = surface_field(task, pupil, {ensemble.terms, c}, 1);
          else
            surface.apply(c, &field);
          group->put(d * law::kRaysOfDraw, trace(task.mirror, pupil, field), nominal, 1.0 / count);
        }
      });
}

EnsembleMean ensemble_of_perturbed_rays(const Task& task, double slope, int draws,
                                        const std::vector<Statistic>& statistics, int threads) {
  return mean_of_groups(
      task, draws, statistics, threads,
      [&](std::size_t g, int count, const PupilSample& pupil, const RayBundle& nominal, Gathered* group) {
        const RandomStream seeds(task.trace.pupil.seed, "ensemble-perturbed-rays");
        for (int d = 0; d < count; ++d) {
          const std::uint64_t seed = seeds.bits(g * std::uint64_t(count) + std::uint64_t(d));
          group->put(d * law::kRaysOfDraw,
                     trace_perturbed(task.mirror, pupil, slope, task.target.convention, seed), nominal,
                     1.0 / count);
        }
      });
}

void compare_in_light(const Ensemble& ensemble, const Groundwork& ground,
                      const std::optional<GivenSurface>& given, const std::vector<Statistic>& statistics,
                      int threads, VerifyReport* report) {
  const Task& task = ensemble.task;
  report->light_obstacle = ground.use.obstacle;
  if (!report->light_obstacle.empty()) return;
  try {
    const GeneralisedHarveyShack ghs(*ground.prior_psd, task.mirror, task.aperture, task.wavelength);
    const LightPlan plan = plan_light(ghs, statistics);
    const double pitch = wave_pitch(task, ensemble.terms, plan.extent, nullptr);
    WaveShares shares;
    if (given) {
      const FreshStatistics fresh = statistics_with_error(
          lit_mirror(task, nullptr), {FocusModel::kWaves, 0, task.trace.pupil.seed, pitch}, given->terms,
          given->coefficients, plan.shares, threads, nullptr);
      shares.mean = {fresh.value, fresh.standard_error};
    } else {
      const double cells = std::pow(2 * ground.radius / pitch, 2);
      const int most =
          int(law::kMostDraws * std::pow(law::kMostCells, 2) / cells) / law::kGroups * law::kGroups;
      report->light_draws = std::clamp(ensemble.draws, law::kGroups, std::max(most, law::kGroups));
      shares = shares_of_draws(ensemble, plan, pitch, report->light_draws, threads);
    }
    for (const LightRow& row : plan.rows)
      report->light.push_back(light_metric(row, shares.mean, shares.groups, task.equivalence));
    report->light_verdict = overall(report->light);
  } catch (const ComputationError& error) {
    report->light.clear();
    report->light_draws = 0;
    report->light_obstacle = error.what();
  }
}

}  // namespace internal

int ensemble_draws(double spread) {
  // Standard errors in a margin, times what the predicted spread is known to.
  const double wanted = std::pow(1.5 * (1.75 + 2.87) * spread, 2) / law::kGroups;
  // Not a number where the spread is none: then as many as there may be.
  const double groups =
      wanted <= law::kMostGroupDraws ? std::max(2.0, std::ceil(wanted)) : law::kMostGroupDraws;
  return int(groups) * law::kGroups;
}

EquivalenceMetric share_metric(const std::string& name, double fraction, double radius, double slope,
                               double share, double error, double margin, double confidence) {
  // Differences in units in which `margin` is the tolerance; a test of 1 + difference against 1.
  const double unit = std::max(radius * slope, kFlattestCurve);
  EquivalenceMetric metric =
      tost(name, false, 1, 0, 1 + (fraction - share) / unit, error / unit, margin, confidence);
  metric.target = radius;
  const double shift = (fraction - share) / slope;
  // Further off than a third of the radius the slope says nothing of where it is.
  metric.model = std::abs(shift) <= radius / 3 ? radius + shift : std::nan("");
  return metric;
}

}  // namespace aberfit
