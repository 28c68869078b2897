#pragma once
#include <algorithm>
#include <limits>
#include <memory>
#include <optional>

#include "aberfit/method/frontier.h"
#include "aberfit/method/mirror_spread.h"
#include "aberfit/method/physics_choice.h"
#include "aberfit/method/task.h"
#include "aberfit/theory/band_split.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/geometric_harvey_shack.h"
#include "aberfit/theory/regime.h"

namespace aberfit {

/// The quantities that every command derives from a task before its own work.
struct Groundwork {
  std::optional<RadialPsd> psd;  ///< of the specification
  /// The split of the roughness between terms and scatter; null: terms carry all of it.
  std::shared_ptr<const BandSplit> split;
  bool all_scatters() const { return split && !split->has_low() && !segments_err; }  ///< no term is needed
  bool segments_err = false;           ///< segment pistons and tilts are terms
  std::optional<BandShares> shares;    ///< of the split
  std::optional<MirrorSpread> spread;  ///< spread of the laid-out targets; absent: not requested
  std::optional<RadialPsd> term_psd;   ///< the part of `psd` that terms represent: all of it, or its low part
  std::optional<RadialPsd> prior_psd;  ///< of the equivalent surface: heights halved in convention `paper`
  double prior_height_factor = 1;
  SceneNumbers numbers;
  bool is_band = false;    ///< several wavelengths; Airy rings then have no common width
  double radius = 0;       ///< aperture radius [m]
  double focal_sigma = 0;  ///< scale of the focal spot [m]: sigma of a Gaussian with the theory's ee90
  std::optional<GeometricHarveyShack> theory;
  PhysicsChoice use;
  std::shared_ptr<const GeneralisedHarveyShack> mean_spot;  ///< for theory ghs, else null
  /// The GHS spot of the specification: mean_spot, or a separate one where targets come from rays.
  std::shared_ptr<const GeneralisedHarveyShack> specified_spot;
  /// Like focal_sigma, for the sharpest part of the spot [m]: the core of a diffracted spot with a halo.
  double core_sigma = 0;
  double focal_length = 0;                                             ///< [m]
  bool is_deep() const { return core_sigma > kDeepestUnit * radius; }  ///< depth of focus above f/10
  double half_side = 0;  ///< half the smaller side of the aperture's box [m]
  /// Returns whether the mean spot has a core. It has one by rays, without a mean spot, and where the mean
  /// transfer function of the roughness between points half a side apart is at least law::kUnseenLight.
  /// Roughness slower than the aperture does not reduce the core.
  bool has_core() const;
  /// Largest defocus of the default planes [default_unit].
  double default_planes() const;
  /// Natural unit of dz [m]: a depth of focus, at most a tenth of the focal length.
  double plane_unit() const { return std::min(core_sigma / radius, kDeepestUnit) * focal_length; }
  /// Largest defocus of the default planes of a spot without a core [m], for which waves need at most
  /// law::kMostCells grid cells across.
  double farthest_by_cells = std::numeric_limits<double>::infinity();
  /// Unit of the default planes [m]: `plane_unit`, or less so that they lie within `farthest_by_cells`.
  double default_unit() const { return std::min(plane_unit(), farthest_by_cells / default_planes()); }
};
/// Chooses theory and model by `choose_physics`. One exception gives theory `rays`: the choice is a closed
/// form with rays, the study names no theory, and 4.6 slope^2, the error of closed forms (PHYSICS 5), exceeds
/// the closest tolerance. If all targets are given, there is no theory and the choice stays.
Groundwork lay_groundwork(const Task& task);
/// The same with the requested physics instead of the task's own.
Groundwork lay_groundwork(const Task& task, const PhysicsRequest& asked);

/// Number of exact dependencies between the m = 0 Zernikes and the spherical powers, judged by their slopes
/// (a constant height moves no ray).
int radial_overlap(const TermSet& terms);

/// Fitted statistics with values and tolerances, guides between them (default set only), and held-out
/// statistics, which have the theory's value and no tolerance. `held_out` is empty when a value is given.
struct TargetSets {
  std::vector<Target> fitted, guides, held_out;
  std::string theory;  ///< "geometric", "rays", "ghs", or "given"
  Warnings warnings;   ///< `target-missing`: statistics of the default set without a value by the theory
};
/// All targets of a surface: fitted, guides and held out.
std::vector<Target> all_targets(const TargetSets& targets);
/// True when all of the task's statistics have a given value, so that no theory is needed.
bool targets_are_given(const Task& task);
TargetSets make_targets(const Task& task, const Groundwork& ground, int threads);

/// Warnings that follow from the specification alone.
Warnings scene_warnings(const Task& task, const Groundwork& ground, const TermSet& terms, double captured);

}  // namespace aberfit
