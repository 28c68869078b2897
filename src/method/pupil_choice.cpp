#include "aberfit/method/pupil_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {
double plane_reach(const Target& target) {
  if (kind_of(target.statistic).plane == FocalPlane::kThrough) return 0.5 * law::kReach * target.value;
  return std::abs(plane_of_light(target.statistic).value_or(0));
}

namespace {

// Planes on both sides of the focus that a grid must represent [m].
struct PlanesSeen {
  double nearest = 0, farthest = 0;

  void add(const Target& target) {
    const double dz = plane_of_light(target.statistic).value_or(0), around = plane_reach(target);
    const bool both = kind_of(target.statistic).plane == FocalPlane::kThrough;
    nearest = std::min(nearest, both ? -around : dz);
    farthest = std::max(farthest, both ? around : dz);
  }
  double reach() const { return std::max(-nearest, farthest); }
};

// Pitch for energy at `radius` [m] in the focus. The field of view grows with the distance from the mirror,
// as the image does in other planes.
double pitch_for_light(const Task& task, double radius, const PlanesSeen& planes) {
  const double f = task.mirror.focal_length;
  double pitch = HUGE_VAL;
  for (const double dz : {planes.nearest, planes.farthest})
    if (f + dz > 0)  // no ring lies behind the mirror
      pitch = std::min(pitch, diffraction_sampling(task.aperture, f, task.wavelength.shortest(),
                                                   radius * (f + dz) / f, dz, law::kLeastCells)
                                  .pitch);
  return pitch;
}

// The subject and verb of a sentence. radius: 0 where all energy is scattered and needs no field of view.
std::string what_asks_for(double radius, const PlanesSeen& planes) {
  const std::string out =
      fmt::format("planes up to {} out of focus", format_quantity(planes.reach(), Dimension::kLength));
  if (radius == 0) return out + " need it";
  return fmt::format("energy {} from the axis, in {}, needs it", format_quantity(radius, Dimension::kLength),
                     out);
}

}  // namespace

double wave_pitch(const Task& task, const TermSet& terms, const std::vector<Target>& targets,
                  const BandSplit* split, double coarsening, double least_reach) {
  double radius = 0;
  PlanesSeen planes;
  for (const Target& target : targets) {
    const double deciding = deciding_radius(target.statistic, target.value);
    if (std::isfinite(deciding))
      radius = std::max(radius, law::kReach * deciding);
    else if (split)
      radius = std::max(radius, law::kReach * split->low_reach());  // radius of all energy that terms move
    planes.add(target);
  }
  if (split) radius = std::min(radius, law::kReach * split->low_reach());
  radius = std::max(radius, law::kReach * least_reach);
  const double for_light = coarsening * pitch_for_light(task, radius, planes);
  double highest = 0;  // highest frequency of the terms [cycles/m]
  for (const FourierMode& mode : terms.fourier) highest = std::max(highest, std::hypot(mode.fx, mode.fy));
  if (!terms.zernike.empty())
    highest = std::max(highest, zernike_cutoff(terms.zernike.back().n, terms.radius));
  for (const KnownZernike& term : task.mirror.zernike)
    highest = std::max(highest, zernike_cutoff(term.mode.n, task.mirror.zernike_radius));
  // At the rim a cell of the wave pupil is longer on the mirror than its pitch, by dr/dP at most.
  const double t = aperture_radius(task.aperture) / (2 * task.mirror.focal_length);
  const double longer = (1 + t * t) * (1 + t * t) / (1 - t * t);
  const double for_terms = highest > 0 ? 1 / (law::kCellsPerCycle * highest * longer) : HUGE_VAL;
  const double pitch = std::min(for_light, for_terms);
  const double cells = 2 * aperture_radius(task.aperture) / pitch;
  if (!(cells <= kMostCells))
    throw ComputationError(fmt::format(
        "wave optics would need a grid of {:.0f} points across the aperture, more than {}: {}", cells,
        kMostCells,
        for_terms < for_light
            ? fmt::format("terms of up to {:.4g} cycles/m need it; take fewer", highest)
            : what_asks_for(radius, planes) +
                  "; take smaller fractions, rings or planes, or `\"model\": \"rays\"` in `trace`"));
  return pitch;
}

namespace {

bool rounding_is_small(const TargetSets& targets) {
  // Single precision rounds to 1e-7 of the energy; every tolerance is at least a thousand times that.
  constexpr double closest = 1e3 * 1e-7;
  return std::all_of(targets.fitted.begin(), targets.fitted.end(), [](const Target& target) {
    return target.tolerance >= closest * std::abs(target.value);
  });
}

}  // namespace

bool in_single_precision(FocusModel model, const TargetSets& targets, Eigen::Index cells) {
  return model == FocusModel::kWaves && cells >= law::kManyCells && rounding_is_small(targets);
}

Eigen::Index cells_of(const Task& task, double pitch) {
  return pitch > 0 ? Eigen::Index(aperture_area(task.aperture) / (pitch * pitch)) : 0;
}

PupilSample focus_pupil(const Task& task, FocusModel model, const PupilOptions& rays, double pitch) {
  if (model == FocusModel::kWaves)
    return diffraction_pupil(task.aperture, task.mirror.focal_length, pitch).sample;
  return make_pupil(task.aperture, rays);
}

LitMirror lit_mirror(const Task& task, std::shared_ptr<const BandSplit> split) {
  return {task.mirror, task.aperture, task.wavelength, task.trace.centre, std::move(split)};
}

}  // namespace aberfit
