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

// Rays of many realisations in sequence, with the directions of their nominal rays.
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

// Mean over all realisations, and its standard error from groups evaluated separately. `light` fills the rays
// of a group from an index on. A group shares its pupil, so that law::kGroups pupils sample the aperture; the
// sampling error of one realisation is noise that the mean averages.
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
  ensemble.context.stop_if_asked();
  const std::uint64_t seed = RandomStream(ensemble.task.fit.seed, "ensemble-draws").bits(draw);
  return ensemble.prior.colour(draw_white(ensemble.prior.size(), seed));
}

// The parts of a wave-optics metric: the value of theory, and the energy fractions to compute.
struct LightRow {
  Target target;
  std::vector<std::size_t> shares;  // indices: one, or for a ring those below, in and above its peak
  double rise = 0, fall = 0;        // ring: |dN/dz| at its two ends over N at its peak [1/m]
};
struct LightPlan {
  std::vector<LightRow> rows;
  std::vector<Statistic> shares;

  std::size_t add(double radius, double dz) {
    shares.push_back(RingThrough{radius, dz});
    return shares.size() - 1;
  }
  std::vector<Target> targets() const {
    std::vector<Target> all;
    for (const LightRow& row : rows) all.push_back(row.target);
    return all;
  }
};

LightPlan plan_light(const GeneralisedHarveyShack& ghs, const std::vector<Statistic>& statistics) {
  LightPlan plan;
  for (const Statistic& statistic : statistics) {
    LightRow row{{statistic}, {}};
    if (const auto* ee = std::get_if<EncircledEnergyRadius>(&statistic)) {
      const MeanSpot spot = ghs.at_plane(ee->dz);
      const double radius = row.target.value = spot.encircled_energy_radius(ee->fraction);
      if (!std::isfinite(radius)) continue;
      row.target.curve_slope = radius * spot.encircled_energy_slope(radius);
      row.shares = {plan.add(radius, ee->dz)};
    } else if (const auto* ring = std::get_if<RingFwhm>(&statistic);
               ring && !ring->ring_radius && ring->ring_fraction == 0.9) {
      const double radius = ghs.encircled_energy_radius(ring->ring_fraction, 0);
      const GeneralisedHarveyShack::RingPlanes planes = ghs.ring_planes(radius);
      const double width = row.target.value = planes.upper - planes.lower;
      if (!std::isfinite(width)) continue;
      const double step = 0.01 * width, most = ghs.encircled_energy(radius, planes.peak);
      const auto steepness = [&](double plane) {
        return std::abs(ghs.encircled_energy(radius, plane - step) -
                        ghs.encircled_energy(radius, plane + step)) /
               (2 * step * most);
      };
      row.rise = steepness(planes.lower);
      row.fall = steepness(planes.upper);
      row.shares = {plan.add(radius, planes.lower), plan.add(radius, planes.peak),
                    plan.add(radius, planes.upper)};
    } else {
      continue;
    }
    plan.rows.push_back(row);
  }
  return plan;
}

// The radius that holds the fraction, to first order; NaN for a shift above a third of the radius.
double shifted_radius(const Target& target, double share) {
  const double radius = target.value, fraction = std::get<EncircledEnergyRadius>(target.statistic).fraction;
  const double shift = (fraction - share) * radius / *target.curve_slope;
  return std::abs(shift) <= radius / 3 ? radius + shift : kNaN;
}

EquivalenceMetric light_metric(const LightRow& row, const EnsembleMean& shares, const Eigen::MatrixXd& groups,
                               const EquivalenceSpec& test) {
  const auto at = [&](std::size_t k) { return Eigen::Index(row.shares[k]); };
  const bool drawn = groups.cols() > 1;
  const double freedom = drawn ? kGroupFreedom : kInfinity;
  const auto judged = [&](double shown, double value, double error) {
    return judge_target(row.target, false, shown, value, error, test.margin, test.confidence, freedom);
  };
  if (row.shares.size() == 1) {
    const double share = shares.value[at(0)];
    return judged(shifted_radius(row.target, share), share, shares.standard_error[at(0)]);
  }
  // Each end of the width moves by the energy in excess of half the peak, divided by the slope there.
  const auto width_of = [&](const auto& of) {
    const double peak = of[at(1)];
    return row.target.value + (of[at(0)] / peak - 0.5) / row.rise + (of[at(2)] / peak - 0.5) / row.fall;
  };
  const double width = width_of(shares.value);
  if (!drawn) return judged(width, width, shares.standard_error[at(1)] / std::min(row.rise, row.fall));
  Eigen::MatrixXd widths(1, groups.cols());
  for (Eigen::Index g = 0; g < groups.cols(); ++g) widths(0, g) = width_of(groups.col(g));
  return judged(width, width, standard_error_of_mean(widths)[0]);
}

struct WaveShares {
  EnsembleMean mean;
  Eigen::MatrixXd groups;  // energy fractions by groups; empty for a given surface
};

WaveShares shares_of_draws(const Ensemble& ensemble, const LightPlan& plan, double pitch, int draws) {
  const Task& task = ensemble.task;
  const PupilSample pupil = focus_pupil(task, FocusModel::kWaves, task.trace.pupil, pitch);
  const SurfaceOperator surface(ensemble.terms, pupil, focus_operator(FocusModel::kWaves, 1));
  const LightPath path{task.mirror,     pupil,          surface,          FocusModel::kWaves,
                       task.wavelength, &task.aperture, task.trace.centre};
  WaveShares shares;
  shares.groups = Eigen::MatrixXd::Zero(Eigen::Index(plan.shares.size()), law::kGroups);
  const int per_group = draws / law::kGroups;
  parallel_for(law::kGroups, ensemble.context.threads, [&](std::size_t g) {
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

EnsembleMean ensemble_by_rays(const Ensemble& ensemble, const std::vector<Statistic>& statistics) {
  const Task& task = ensemble.task;
  return mean_of_groups(
      task, ensemble.draws, statistics, ensemble.context.threads,
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
                      VerifyReport* report) {
  const Task& task = ensemble.task;
  report->light_obstacle = ground.use.obstacle;
  if (!report->light_obstacle.empty()) return;
  try {
    const GeneralisedHarveyShack ghs(*ground.prior_psd, task.mirror, task.aperture, task.wavelength);
    const LightPlan plan = plan_light(ghs, statistics);
    const double pitch = wave_pitch(task, ensemble.terms, plan.targets(), nullptr);
    WaveShares shares;
    if (given) {
      const FreshStatistics fresh = statistics_with_error(
          lit_mirror(task, nullptr), {FocusModel::kWaves, 0, task.trace.pupil.seed, pitch}, given->terms,
          given->coefficients, plan.shares, ensemble.context.threads, nullptr);
      shares.mean = {fresh.value, fresh.standard_error};
    } else {
      const double cells = std::pow(2 * ground.radius / pitch, 2);
      const int most =
          int(law::kMostDraws * std::pow(law::kMostCells, 2) / cells) / law::kGroups * law::kGroups;
      report->light_draws = std::clamp(ensemble.draws, law::kGroups, std::max(most, law::kGroups));
      shares = shares_of_draws(ensemble, plan, pitch, report->light_draws);
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
  // Standard errors in a margin, times the factor to which the predicted spread is known.
  const double wanted = std::pow(1.5 * (1.75 + 2.87) * spread, 2) / law::kGroups;
  // A NaN spread gives the largest ensemble.
  const double groups =
      wanted <= law::kMostGroupDraws ? std::max(2.0, std::ceil(wanted)) : law::kMostGroupDraws;
  return int(groups) * law::kGroups;
}

}  // namespace aberfit
