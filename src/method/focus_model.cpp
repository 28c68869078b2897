#include "aberfit/method/focus_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/units.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {
namespace {

constexpr double kReach = 1.5;          // of the largest EE radius (diffraction_sampling)
constexpr int kLeastCells = 128;        // across: Airy radii to 3e-5
constexpr double kCellsPerCycle = 3.0;  // a phase screen sampled twice a cycle folds its own side orders

bool is_parabola(const Mirror& mirror) {
  return mirror.conic == -1 &&
         std::all_of(mirror.spherical.begin(), mirror.spherical.end(), [](double c) { return c == 0; });
}

// Why diffraction about the perfect focus says nothing about this task.
std::string obstacle_of(const Task& task) {
  if (!is_parabola(task.mirror)) return "the mirror is no parabola, so it has no perfect focus";
  if (std::holds_alternative<PolygonAperture>(task.aperture))
    return "the diffraction pattern of a polygon is not part of the theory";
  if (task.trace.centre == Centre::kCentroid) return "statistics about the centroid exist for rays only";
  return "";
}

Theory theory_of(FocusModel model) {
  return model == FocusModel::kRays        ? Theory::kGeometric
         : model == FocusModel::kConvolved ? Theory::kConvolved
                                           : Theory::kGhs;
}

FocusPhysics physics_of(Theory theory) {
  return theory == Theory::kGhs         ? FocusPhysics::kWaves
         : theory == Theory::kConvolved ? FocusPhysics::kConvolved
                                        : FocusPhysics::kRays;
}

// What a study names must be computable; what is left to the program may fall back.
void check_named(const Task& task, const std::string& obstacle) {
  const Theory theory = task.target.theory;
  const bool wave_theory = theory == Theory::kConvolved || theory == Theory::kGhs;
  const bool paper = task.target.convention == Convention::kPaper;
  if (wave_theory && paper)
    throw FieldError("target.theory",
                     '"' + to_string(theory) + "\" with convention \"paper\", a rule for rays alone",
                     "\"auto\", \"geometric\", \"rays\"; or convention \"physical\"");
  if (wave_theory && !obstacle.empty())
    throw FieldError("target.theory", '"' + to_string(theory) + "\", but " + obstacle,
                     "\"auto\", \"geometric\", \"rays\"");
  const bool wave_model =
      task.trace.model == TraceModel::kConvolved || task.trace.model == TraceModel::kWaves;
  if (wave_model && !obstacle.empty())
    throw FieldError("trace.model",
                     task.trace.model == TraceModel::kWaves ? "\"waves\", but " + obstacle
                                                             : "\"convolved\", but " + obstacle,
                     "\"auto\", \"rays\"");
}

}  // namespace

std::string to_string(Theory theory) {
  static const char* const kNames[] = {"auto", "geometric", "rays", "convolved", "ghs"};
  return kNames[int(theory)];
}

std::string to_string(FocusPhysics physics) {
  static const char* const kNames[] = {"rays", "convolved", "waves"};
  return kNames[int(physics)];
}

FocusPhysics physics_of(FocusModel model) { return physics_of(theory_of(model)); }

bool ModelUse::too_simple(bool targets_are_given) const {
  if (!choice) return false;
  const int needed = int(physics_of(choice->model)), of_surface = int(physics);
  const int used = targets_are_given ? of_surface : std::min(of_surface, int(physics_of(theory)));
  return used < needed;
}

ModelUse decide_model(const Task& task, const RadialPsd* psd) {
  ModelUse use;
  use.obstacle = obstacle_of(task);
  check_named(task, use.obstacle);
  if (psd) {
    use.choice = choose_model(*psd, task.mirror, task.aperture, task.wavelength);
    use.reason = use.choice->reason;
  }
  use.theory = task.target.theory;
  if (use.theory == Theory::kAuto) {
    use.theory = use.choice ? theory_of(use.choice->model) : Theory::kGeometric;
    if (use.theory != Theory::kGeometric && task.target.convention == Convention::kPaper) {
      use.theory = Theory::kGeometric;
      use.warnings.push_back({"theory-fallback",
                              "convention `paper` is a rule for rays and has no wave counterpart: targets "
                              "and surface stay geometric, although the scene needs more"});
    } else if (use.theory != Theory::kGeometric && !use.obstacle.empty()) {
      use.theory = Theory::kGeometric;
      use.warnings.push_back({"theory-fallback", "the scene needs more than geometric rays, but " +
                                                     use.obstacle + ": targets and surface stay geometric"});
    }
  }
  use.physics = task.trace.model == TraceModel::kAuto ? physics_of(use.theory)
                                                       : FocusPhysics(int(task.trace.model) - 1);
  return use;
}

void refuse_without_rays(const Task& task, const std::string& model,
                         const std::vector<Statistic>& statistics) {
  for (const Statistic& statistic : statistics)
    if (std::holds_alternative<RmsRadius>(statistic))
      throw FieldError(
          "target.statistics.rms_radius",
          "an RMS radius with model \"" + model + "\": diffraction at the edge makes it infinite",
          "ee radii; or theory \"geometric\" and trace model \"rays\"");
}

Eigen::VectorXd mean_spot_statistics(const GeneralisedHarveyShack& spot,
                                     const std::vector<Statistic>& statistics, int threads) {
  Eigen::VectorXd values(Eigen::Index(statistics.size()));
  std::map<double, std::vector<std::size_t>> planes;  // a plane is set up once for all of its radii
  std::vector<std::vector<std::size_t>> jobs;
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    if (const auto* ee = std::get_if<EncircledEnergyRadius>(&statistics[k]))
      planes[ee->dz].push_back(k);
    else if (const auto* ring = std::get_if<RingThrough>(&statistics[k]))
      planes[ring->dz].push_back(k);
    else
      jobs.push_back({k});
  }
  const std::size_t searches = jobs.size();
  for (auto& [dz, members] : planes) jobs.push_back(std::move(members));
  parallel_for(jobs.size(), threads, [&](std::size_t j) {
    if (j < searches) {
      values[Eigen::Index(jobs[j].front())] = spot(statistics[jobs[j].front()]);
      return;
    }
    std::optional<MeanSpot> plane;
    for (const std::size_t k : jobs[j]) {
      const auto* ee = std::get_if<EncircledEnergyRadius>(&statistics[k]);
      const auto* ring = std::get_if<RingThrough>(&statistics[k]);
      if (!plane) plane = spot.at_plane(ee ? ee->dz : ring->dz);
      values[Eigen::Index(k)] =
          ee ? plane->encircled_energy_radius(ee->fraction) : plane->encircled_energy(ring->ring_radius);
    }
  });
  return values;
}

double wave_pitch(const Task& task, const TermSet& terms, const std::vector<Target>& targets) {
  double radius = 0, reach_dz = 0;
  for (const Target& target : targets) {
    if (const auto* ee = std::get_if<EncircledEnergyRadius>(&target.statistic)) {
      if (ee->dz == 0) radius = std::max(radius, kReach * target.value);
      reach_dz = std::max(reach_dz, std::abs(ee->dz));
    } else if (const auto* ring = std::get_if<RingThrough>(&target.statistic)) {
      radius = std::max(radius, kReach * ring->ring_radius);
      reach_dz = std::max(reach_dz, std::abs(ring->dz));
    } else if (std::holds_alternative<RingFwhm>(target.statistic)) {
      reach_dz = std::max(reach_dz, 0.5 * kReach * target.value);
    }
  }
  const DiffractionSampling sampling = diffraction_sampling(task.aperture, task.mirror.focal_length,
                                                            task.wavelength, radius, reach_dz, kLeastCells);
  double highest = 0;  // of the terms [cycles/m]
  for (const FourierMode& mode : terms.fourier) highest = std::max(highest, std::hypot(mode.fx, mode.fy));
  if (!terms.zernike.empty())
    highest = std::max(highest, (terms.zernike.back().n + 1) / (2 * std::numbers::pi * terms.radius));
  const double for_terms = highest > 0 ? 1 / (kCellsPerCycle * highest) : HUGE_VAL;
  const double pitch = std::min(sampling.pitch, for_terms);
  const double cells = 2 * aperture_radius(task.aperture) / pitch;
  if (!(cells <= kMostCells))
    throw ComputationError(fmt::format(
        "waves would need a grid of {:.0f} cells across the aperture, more than {}: {}", cells, kMostCells,
        for_terms < sampling.pitch
            ? fmt::format("terms of up to {:.4g} cycles/m ask for it; take fewer", highest)
            : fmt::format(
                  "light {} from the axis, in planes up to {} out of focus, asks for it; take smaller "
                  "fractions, rings or planes, or `\"model\": \"rays\"` in `trace`",
                  format_quantity(radius, Dimension::kLength),
                  format_quantity(reach_dz, Dimension::kLength))));
  return pitch;
}

PupilSample focus_pupil(const Task& task, FocusPhysics physics, const PupilOptions& rays, double pitch) {
  if (physics == FocusPhysics::kWaves) return diffraction_pupil(task.aperture, pitch).sample;
  return make_pupil(task.aperture, rays);
}

OperatorOptions focus_operator(FocusPhysics physics, int threads) {
  OperatorOptions options;
  options.threads = threads;
  options.hold_at_rim = physics == FocusPhysics::kWaves;
  return options;
}

}  // namespace aberfit
