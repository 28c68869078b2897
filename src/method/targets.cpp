#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"
#include "aberfit/core/units.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/theory/ray_perturbation.h"
#include "aberfit/waves/diffraction_psf.h"
#include "given_values.h"
#include "light_guides.h"
#include "statistic_request.h"

namespace aberfit {
using namespace internal;

namespace {

// Middles between the fitted values, for guides with a wider tolerance. Without guides, EE radii halfway
// between the fitted ones stay up to 1.4 % off (fits/paper-physical).
template <std::size_t n>
std::vector<double> middles_of(const double (&fitted)[n]) {
  std::vector<double> sorted(fitted, fitted + n), middles;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t k = 0; k + 1 < n; ++k) middles.push_back(0.5 * (sorted[k] + sorted[k + 1]));
  return middles;
}

// Planes on both sides of the focus at multiples of a unit [m], up to `reach` [m].
struct Planes {
  double unit, reach = 0;

  // Rounds to short names: to 1 um, in a shallow focus to 5 % of the unit or less.
  double at(double units) const {
    const double step = std::min(1e-6, std::pow(10.0, std::floor(std::log10(unit / 20))));
    return units == 0 ? 0 : step * std::round(units * unit / step);
  }
  std::vector<double> within_reach(std::span<const double> units) const {
    std::vector<double> planes;
    for (const double of : units)
      if (const double dz = at(of); std::abs(dz) <= reach) planes.push_back(dz);
    return planes;
  }
};

bool in_halo(const Groundwork& ground, double fraction) {
  return ground.mean_spot &&
         ground.mean_spot->encircled_energy_radius(fraction, 0) > law::kHalo * ground.core_sigma;
}

// The energy in a ring falls to half some depths of focus away, where a deep focus has no planes.
bool has_ring(const Groundwork& ground, double fraction) {
  return !ground.is_deep() && !ground.is_band && !in_halo(ground, fraction);
}

// For a roughness of few modes, the mean irradiance is not that of a mirror with the mean height: irradiance
// is not linear in the squared height (Jensen). One surface of few modes cannot meet both.
bool has_few_modes(const Groundwork& ground) {
  return ground.numbers.n_eff > 0 && ground.numbers.n_eff < law::kFewModes;
}

// Default statistics leave out the moments of the surface; requested moments stay, with a warning.
void warn_of_few_modes(const Groundwork& ground, bool default_set, TargetSets* sets) {
  if (!has_few_modes(ground)) return;
  const auto& fitted = sets->fitted;
  const bool moments = std::any_of(fitted.begin(), fitted.end(), [](const Target& target) {
    return kind_of(target.statistic).is_moment();
  });
  if (!default_set && !moments) return;
  sets->warnings.push_back(
      {"few-modes", fmt::format("only {:.2g} modes carry the roughness (N_eff). Then one surface cannot have "
                                "both the mean PSF of such mirrors and their mean height and slope; {}",
                                ground.numbers.n_eff,
                                default_set ? "by default only the PSF is judged"
                                            : "request only encircled energies, or a band of more modes")});
}

Planes default_planes(const Groundwork& ground) {
  Planes planes{ground.default_unit()};
  planes.reach = std::abs(planes.at(ground.default_planes()));
  return planes;
}

// Planes for named statistics. They extend to the first multiple of the natural unit at or beyond the
// farthest named plane, so that guides lie around it; the default planes are used where they suffice. Where
// grid cells limit the default planes, the planes end at the farthest named one, because the natural unit may
// be ten times larger. The planes of a ring are not known yet.
Planes planes_around(const std::vector<Wanted>& wanted, const Groundwork& ground) {
  double asked = 0;
  for (const Wanted& one : wanted)
    asked = std::max(asked, std::holds_alternative<RingFwhm>(one.statistic)
                                ? HUGE_VAL
                                : std::abs(plane_of_light(one.statistic).value_or(0)));
  const Planes usual = default_planes(ground);
  if (asked <= usual.reach) return usual;
  const double by_default = ground.default_planes();
  if (ground.default_unit() < ground.plane_unit() && asked < by_default * ground.plane_unit()) {
    Planes planes{asked / by_default};
    planes.reach = std::max(asked, std::abs(planes.at(by_default)));
    return planes;
  }
  Planes planes{ground.plane_unit()};
  planes.reach = std::abs(planes.at(law::kFittedPlanes[std::size(law::kFittedPlanes) - 1]));
  for (const double units : law::kFittedPlanes)
    if (const double dz = std::abs(planes.at(units)); dz >= asked) planes.reach = std::min(planes.reach, dz);
  return planes;
}

std::vector<Wanted> default_statistics(const Groundwork& ground) {
  std::vector<Wanted> wanted;
  for (const double dz : default_planes(ground).within_reach(law::kFittedPlanes))
    for (const double fraction : law::kFittedShares) wanted.push_back({EncircledEnergyRadius{fraction, dz}});
  if (has_ring(ground, RingFwhm{}.ring_fraction)) wanted.push_back({RingFwhm{}});
  if (has_few_modes(ground)) return wanted;
  wanted.push_back({ScatterRms{}});
  wanted.push_back({RmsHeight{}});
  return wanted;
}

double theory_radius(const Groundwork& ground, double fraction) {
  return ground.mean_spot ? ground.mean_spot->encircled_energy_radius(fraction, 0)
                          : ground.theory->encircled_energy_radius(fraction, 0);
}

std::vector<Wanted> requested_statistics(const Task& task, const Groundwork& ground) {
  const RingOf ring_of = [&](double fraction) {
    if (!ground.theory)
      throw FieldError("target.statistics.ring_profile.ring", "an encircled-energy ring without roughness",
                       "a length, e.g. \"76 um\"");
    return theory_radius(ground, fraction);
  };
  std::vector<Wanted> wanted;
  for (const StatisticRequest& request : task.target.statistics)
    for (const Wanted& of : wanted_by(request, ring_of, ground.focal_sigma)) wanted.push_back(of);
  return wanted;
}

// An aperture transmits no image frequency above D/(lambda f).
void check_frequencies(const Task& task, const Groundwork& ground, const std::vector<Wanted>& wanted) {
  const double cutoff = 2 * ground.radius / (task.wavelength * ground.focal_length);
  for (const Wanted& one : wanted)
    if (const auto* mtf = std::get_if<ModulationTransfer>(&one.statistic); mtf && !(mtf->frequency < cutoff))
      throw FieldError("target.statistics.mtf.frequencies",
                       format_quantity(mtf->frequency, Dimension::kSpatialFrequency),
                       fmt::format("below the cutoff of this aperture and wavelength, D/(lambda f) = {}",
                                   format_quantity(cutoff, Dimension::kSpatialFrequency)));
}

// Guides by rays. Waves have guides of their own, see light_guides.
std::vector<Statistic> guide_statistics(const Groundwork& ground, const Planes& planes) {
  std::vector<Statistic> guides;
  if (ground.use.model == FocusModel::kWaves && ground.mean_spot) {
    // No other statistic of a diffracted focus constrains the mean of the slopes.
    if (!has_few_modes(ground)) guides.push_back(ScatterMean{});
    return guides;
  }
  std::vector<double> between = middles_of(law::kFittedPlanes), shares = middles_of(law::kFittedShares);
  between.push_back(0);
  shares.pop_back();  // beyond 90 % of the energy rings hold too many rays to vary
  for (const double units : between)
    for (const double share : shares) guides.push_back(EncircledEnergyRadius{share, planes.at(units)});
  return guides;
}

// known: fitted statistics and guides, which cannot be held out as well.
std::vector<Statistic> held_out_statistics(const Groundwork& ground, const Planes& planes,
                                           const std::vector<Statistic>& known) {
  std::vector<Statistic> held_out;
  for (const double dz : planes.within_reach(law::kHeldOutPlanes))
    for (const double fraction : law::kHeldOutShares) held_out.push_back(EncircledEnergyRadius{fraction, dz});
  for (const double fraction : {0.5, 0.8})
    if (has_ring(ground, fraction)) held_out.push_back(RingFwhm{fraction, {}});
  if (ground.use.model != FocusModel::kWaves && !has_few_modes(ground)) held_out.push_back(ScatterMean{});
  std::erase_if(held_out, [&](const Statistic& candidate) {
    return std::any_of(known.begin(), known.end(), [&](const Statistic& statistic) {
      return statistic_name(statistic) == statistic_name(candidate);
    });
  });
  return held_out;
}

struct Predicted {
  Eigen::VectorXd value, standard_error;
  Eigen::VectorXd curve_slope;  // r dE/dr of the encircled-energy radii, NaN for the rest
  double degrees_of_freedom = std::numeric_limits<double>::infinity();  // of the errors
};

// The slopes come from the closed form; theory `rays` has the same curve in the mean.
Eigen::VectorXd geometric_curve_slopes(const GeometricHarveyShack& theory,
                                       const std::vector<Statistic>& statistics, int threads) {
  Eigen::VectorXd slopes = Eigen::VectorXd::Constant(Eigen::Index(statistics.size()), kNaN);
  parallel_for(statistics.size(), threads, [&](std::size_t k) {
    const auto* ee = std::get_if<EncircledEnergyRadius>(&statistics[k]);
    if (!ee) return;
    const double radius = theory.encircled_energy_radius(ee->fraction, ee->dz);
    slopes[Eigen::Index(k)] = radius * theory.encircled_energy_slope(radius, ee->dz);
  });
  return slopes;
}

// Theory `rays`: Harvey-Shack by perturbed rays, in independent batches that give the standard error.
Predicted predict_by_rays(const Task& task, const Groundwork& ground,
                          const std::vector<Statistic>& statistics, int threads) {
  constexpr std::int64_t rays_of_group = 2 * law::kMostRays / law::kGroups;
  Eigen::MatrixXd values(Eigen::Index(statistics.size()), law::kGroups);
  parallel_for(law::kGroups, threads, [&](std::size_t b) {
    const std::uint64_t seed = RandomStream(task.trace.pupil.seed, "harvey-shack-target").bits(b);
    const PupilSample pupil = make_pupil(task.aperture, {PupilLayout::kSobol, rays_of_group, seed});
    const RayBundle nominal = trace_nominal(task.mirror, pupil);
    const RayBundle rays =
        trace_perturbed(task.mirror, pupil, ground.numbers.rms_slope_per_axis, task.target.convention, seed);
    // A ray model has no surface, so its height is that of the specification.
    const Eigen::ArrayXd no_height = Eigen::ArrayXd::Zero(rays.size());
    values.col(Eigen::Index(b)) =
        evaluate_exact({rays, nominal, no_height, task.trace.centre}, statistics, 1);
  });
  Predicted predicted;
  predicted.value = values.rowwise().mean();
  predicted.standard_error = standard_error_of_mean(values);
  predicted.degrees_of_freedom = law::kGroups - 1;
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    if (!std::holds_alternative<RmsHeight>(statistics[k])) continue;
    predicted.value[Eigen::Index(k)] = (*ground.theory)(statistics[k]);
    predicted.standard_error[Eigen::Index(k)] = 0;
  }
  predicted.curve_slope = geometric_curve_slopes(*ground.theory, statistics, threads);
  return predicted;
}

Predicted predict(const Task& task, const Groundwork& ground, const std::vector<Statistic>& statistics,
                  int threads) {
  if (ground.use.theory == Theory::kRays) return predict_by_rays(task, ground, statistics, threads);
  Predicted predicted{Eigen::VectorXd(Eigen::Index(statistics.size())),
                      Eigen::VectorXd::Zero(Eigen::Index(statistics.size())),
                      {}};
  if (ground.mean_spot) {
    predicted.value = ground.mean_spot->predict(statistics, threads, &predicted.curve_slope);
    return predicted;
  }
  parallel_for(statistics.size(), threads,
               [&](std::size_t k) { predicted.value[Eigen::Index(k)] = (*ground.theory)(statistics[k]); });
  predicted.curve_slope = geometric_curve_slopes(*ground.theory, statistics, threads);
  return predicted;
}

Predicted predict_curves(const Groundwork& ground, const std::vector<Statistic>& statistics, int threads) {
  Predicted predicted;
  if (!ground.mean_spot) {
    predicted.curve_slope = geometric_curve_slopes(*ground.theory, statistics, threads);
    return predicted;
  }
  std::vector<Statistic> radii;
  for (const Statistic& statistic : statistics)
    if (std::holds_alternative<EncircledEnergyRadius>(statistic)) radii.push_back(statistic);
  Eigen::VectorXd slopes;
  ground.mean_spot->predict(radii, threads, &slopes);
  predicted.curve_slope = Eigen::VectorXd::Constant(Eigen::Index(statistics.size()), kNaN);
  Eigen::Index at = 0;
  for (std::size_t k = 0; k < statistics.size(); ++k)
    if (std::holds_alternative<EncircledEnergyRadius>(statistics[k]))
      predicted.curve_slope[Eigen::Index(k)] = slopes[at++];
  return predicted;
}

[[noreturn]] void refuse_without_focus(const std::string& statistic, const Groundwork& ground) {
  const bool by_diffraction = ground.numbers.airy_ee90 > ground.focal_sigma;
  throw ComputationError(
      fmt::format("the theory has no value for {}. With an RMS slope of {:.3g} per axis and an Airy ee90 of "
                  "{} there is no real focus; check {}",
                  statistic, ground.numbers.rms_slope_per_axis,
                  format_quantity(ground.numbers.airy_ee90, Dimension::kLength),
                  by_diffraction ? "the aperture, its smaller side, and the wavelength"
                                 : "rms and f_max of the roughness"));
}

// r dE/dr of the theory's curve. A given radius only scales the curve, which does not change r dE/dr. Without
// a theory, the curve is that of a Gaussian spot.
std::optional<double> curve_slope_of(const Statistic& statistic, const Predicted& predicted, Eigen::Index k) {
  const auto* ee = std::get_if<EncircledEnergyRadius>(&statistic);
  if (!ee) return std::nullopt;
  if (predicted.curve_slope.size() == 0) return gaussian_curve_slope(ee->fraction);
  const double slope = predicted.curve_slope[k];
  return std::isfinite(slope) ? slope : 0;
}

// No surface gives a smaller encircled-energy radius than the Airy pattern of the parabola at this
// wavelength. Aberrations of a fraction of a wave may reduce it by a percent or two.
void warn_of_sharp_values(const Task& task, const Groundwork& ground, const std::vector<Wanted>& wanted,
                          TargetSets* sets) {
  if (!ground.use.light_decides) return;
  std::optional<GeneralisedHarveyShack> perfect;
  std::vector<std::string> sharp;
  for (const Wanted& one : wanted) {
    const auto* ee = std::get_if<EncircledEnergyRadius>(&one.statistic);
    if (!ee || !one.value) continue;
    if (!perfect) {
      const double highest = 1 / ground.radius;  // of the perfect mirror
      perfect.emplace(
          RadialPsd(UniformPsd{law::kSmoothG / (4 * kPi) * task.wavelength, 0.5 * highest, highest}),
          Mirror{.focal_length = task.mirror.focal_length}, task.aperture, task.wavelength);
    }
    const double least = perfect->encircled_energy_radius(ee->fraction, 0);
    if (*one.value < (1 - law::kNoteworthy) * least)
      sharp.push_back(fmt::format("{} = {} (the perfect mirror: {})", statistic_name(one.statistic),
                                  format_quantity(*one.value, Dimension::kLength),
                                  format_quantity(least, Dimension::kLength)));
  }
  if (sharp.empty()) return;
  sets->warnings.push_back(
      {"below-diffraction",
       fmt::format("no mirror of this aperture and wavelength can have {}", fmt::join(sharp, ", "))});
}

// Returns why the default planes end where they do, as a clause; empty where another warning explains it.
std::string why_no_farther(const Groundwork& ground) {
  if (ground.default_unit() < ground.plane_unit())
    return fmt::format(", because wave optics farther out needs more than {} grid points across",
                       law::kMostCells);
  return ground.is_deep() ? "" : ", where the cone of rays becomes as wide as the scatter";
}

void warn_of_near_planes(const Groundwork& ground, double reach, TargetSets* sets) {
  sets->warnings.push_back(
      {"near-planes", fmt::format("the spot has no core, so the default statistics are of planes within {} "
                                  "of the focus{}. Farther out the surface is not controlled. To add planes, "
                                  "name all wanted statistics in `target.statistics`",
                                  format_quantity(reach, Dimension::kLength), why_no_farther(ground))});
}

// Removes default rings that cannot be computed: without a core, their irradiance falls to half beyond the
// default planes; with one, a grid by waves would need too many cells across to sample the cone of rays.
void leave_out_rings(const Task& task, const Groundwork& ground, double reach, bool default_set,
                     TargetSets* sets) {
  if (ground.use.model != FocusModel::kWaves) return;
  const double by_cells =
      farthest_plane(task.aperture, ground.focal_length, task.wavelength, law::kMostCells);
  const auto far_out = [&](const Target& target) {
    return std::holds_alternative<RingFwhm>(target.statistic) &&
           (plane_reach(target) > by_cells || (!ground.has_core() && 0.5 * target.value > reach));
  };
  std::erase_if(sets->held_out, far_out);
  if (!default_set) return;
  for (const Target& target : sets->fitted)
    if (far_out(target))
      sets->warnings.push_back(
          {"target-missing",
           fmt::format(
               "the energy of {} falls to half {} out of focus, {}, so it is left out of the default "
               "statistics",
               statistic_name(target.statistic), format_quantity(0.5 * target.value, Dimension::kLength),
               plane_reach(target) > by_cells
                   ? fmt::format("where wave optics needs more than {} grid points across", law::kMostCells)
                   : "beyond the default planes of a spot without a core (to have it, name all wanted "
                     "statistics in `target.statistics`)")});
  std::erase_if(sets->fitted, far_out);
}

}  // namespace

bool targets_are_given(const Task& task) {
  const std::vector<StatisticRequest>& requests = task.target.statistics;
  return !requests.empty() && std::all_of(requests.begin(), requests.end(), [](const StatisticRequest& r) {
    return r.value.has_value() || !r.profile_value.empty();
  });
}

std::vector<Target> all_targets(const TargetSets& targets) {
  std::vector<Target> all = targets.fitted;
  all.insert(all.end(), targets.guides.begin(), targets.guides.end());
  all.insert(all.end(), targets.held_out.begin(), targets.held_out.end());
  return all;
}

std::vector<Statistic> statistics_of(const std::vector<Wanted>& wanted) {
  std::vector<Statistic> statistics;
  for (const Wanted& one : wanted) statistics.push_back(one.statistic);
  return statistics;
}

TargetSets make_targets(const Task& task, const Groundwork& ground, int threads) {
  const bool default_set = task.target.statistics.empty();
  const std::vector<Wanted> wanted =
      default_set ? default_statistics(ground) : requested_statistics(task, ground);
  check_given_energies(wanted);
  check_frequencies(task, ground, wanted);
  const auto is_given = [](const Wanted& w) { return w.value.has_value(); };
  const bool any_given = std::any_of(wanted.begin(), wanted.end(), is_given);
  const bool all_given = std::all_of(wanted.begin(), wanted.end(), is_given);
  if (!all_given && !ground.theory)
    throw FieldError("target.statistics", "a statistic without value",
                     "a value for each, or a roughness block to predict them");
  std::vector<Statistic> statistics = statistics_of(wanted), guides, held_out;
  if (ground.use.model != FocusModel::kRays) refuse_without_rays(to_string(ground.use.model), statistics);
  if (ground.mean_spot && !all_given) refuse_without_rays(to_string(ground.use.theory), statistics);
  const Planes planes = default_set ? default_planes(ground) : planes_around(wanted, ground);
  if (!any_given) guides = guide_statistics(ground, planes);
  statistics.insert(statistics.end(), guides.begin(), guides.end());
  // Given values need not follow the theory, so nothing can be held out against it.
  if (!any_given) held_out = held_out_statistics(ground, planes, statistics);
  statistics.insert(statistics.end(), held_out.begin(), held_out.end());
  Predicted predicted;
  if (ground.theory)
    predicted =
        all_given ? predict_curves(ground, statistics, threads) : predict(task, ground, statistics, threads);

  TargetSets sets;
  std::vector<std::string> without_value;
  const bool waves = ground.use.model == FocusModel::kWaves;
  sets.theory = all_given ? "given" : to_string(ground.use.theory);
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    Target target;
    target.statistic = statistics[k];
    const bool given = k < wanted.size() && wanted[k].value;
    target.value = given ? *wanted[k].value : predicted.value[Eigen::Index(k)];
    target.standard_error = given ? wanted[k].standard_error : predicted.standard_error[Eigen::Index(k)];
    target.curve_slope = curve_slope_of(statistics[k], predicted, Eigen::Index(k));
    if (!given) target.degrees_of_freedom = predicted.degrees_of_freedom;
    if (!std::isfinite(target.value) && (default_set || k >= wanted.size())) {
      if (k < wanted.size()) without_value.push_back(statistic_name(statistics[k]));
      continue;
    }
    if (!std::isfinite(target.value)) refuse_without_focus(statistic_name(statistics[k]), ground);
    if (k < wanted.size()) {
      target.asked = wanted[k].asked;
      const bool of_share = kind_of(statistics[k]).dimension == Dimension::kFraction;
      target.tolerance = wanted[k].tolerance * (of_share ? 1.0 : std::abs(target.value));
      sets.fitted.push_back(target);
    } else if (k < wanted.size() + guides.size()) {
      // By rays the curve varies ray by ray between targets, so guides have a closer tolerance at any margin.
      const double margin = waves ? task.equivalence.margin : law::kShareOfMargin * EquivalenceSpec{}.margin;
      target.tolerance = law::kGuideShareOfMargin * margin * std::abs(target.value);
      sets.guides.push_back(target);
    } else {
      sets.held_out.push_back(target);
    }
  }
  if (!any_given && waves && ground.mean_spot) {
    const std::vector<Target> between =
        light_guides(task, ground, planes.within_reach(law::kFittedPlanes), threads);
    sets.guides.insert(sets.guides.end(), between.begin(), between.end());
  }
  if (sets.fitted.empty()) refuse_without_focus(without_value.front(), ground);
  if (default_set && !ground.has_core()) warn_of_near_planes(ground, planes.reach, &sets);
  leave_out_rings(task, ground, planes.reach, default_set, &sets);
  if (!without_value.empty())
    sets.warnings.push_back(
        {"target-missing",
         fmt::format("the default statistics leave out {}, for which the theory has no value",
                     fmt::join(without_value, ", "))});
  warn_of_few_modes(ground, default_set, &sets);
  warn_of_sharp_values(task, ground, wanted, &sets);
  if (default_set && in_halo(ground, RingFwhm{}.ring_fraction))
    sets.warnings.push_back(
        {"target-missing", fmt::format("the ring of {} holds scattered energy, which falls off only far out "
                                       "of focus, so it is left out of the default statistics",
                                       statistic_name(RingFwhm{}))});
  return sets;
}

}  // namespace aberfit
