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

/// What every command derives from a task before it does its own work.
struct Groundwork {
  std::optional<RadialPsd> psd;  ///< of the specification
  /// Where the roughness is split between terms and scatter; null: all of it is the terms'.
  std::shared_ptr<const BandSplit> split;
  bool all_scatters() const { return split && !split->has_low() && !segments_err; }  ///< nothing needs a term
  bool segments_err = false;           ///< their pistons and tilts are terms
  std::optional<BandShares> shares;    ///< of the split
  std::optional<MirrorSpread> spread;  ///< of the targets that it was laid out with, where that was asked
  std::optional<RadialPsd> term_psd;   ///< what the terms stand for: `psd`, or its low part
  std::optional<RadialPsd> prior_psd;  ///< of the equivalent surface: heights halved in convention `paper`
  double prior_height_factor = 1;
  SceneNumbers numbers;
  bool is_band = false;    ///< of several wavelengths, in which rings have no width
  double radius = 0;       ///< aperture radius [m]
  double focal_sigma = 0;  ///< scale of the focal spot [m]: of a Gaussian with the theory's ee90
  std::optional<GeometricHarveyShack> theory;
  PhysicsChoice use;
  std::shared_ptr<const GeneralisedHarveyShack> mean_spot;  ///< of theory ghs, else null
  /// The light of the specification: mean_spot, or what it would be where targets are of rays instead.
  std::shared_ptr<const GeneralisedHarveyShack> specified_spot;
  /// Like focal_sigma, of the sharpest part of the spot [m]: of the core, where a diffracted spot has core
  /// and halo.
  double core_sigma = 0;
  double focal_length = 0;                                             ///< [m]
  bool is_deep() const { return core_sigma > kDeepestUnit * radius; }  ///< deeper than its planes can show
  double half_side = 0;  ///< half the smaller side of the aperture's box [m]
  /// Whether the mean pattern has a core: the roughness' mean transfer function between points half a side
  /// apart is not gone (law::kUnseenLight), or there is no such pattern. What roughness slower than the
  /// aperture does takes nothing from a core.
  bool has_core() const;
  /// How far out planes are looked at by default [default_unit].
  double default_planes() const;
  /// Natural unit of dz [m]: a depth of focus, at most a tenth of the focal length.
  double plane_unit() const { return std::min(core_sigma / radius, kDeepestUnit) * focal_length; }
  /// Of a spot without a core: how far from the focus [m] planes by default may lie, so that waves need no
  /// more than law::kMostCells cells across for them.
  double farthest_by_cells = std::numeric_limits<double>::infinity();
  /// Unit of the planes by default [m]: `plane_unit`, or so little that they lie within `farthest_by_cells`.
  double default_unit() const { return std::min(plane_unit(), farthest_by_cells / default_planes()); }
};
/// Theory and model by `choose_physics`; but where those are a closed form and rays, the study names no
/// theory and 4.6 slope^2, by which closed forms are off (PHYSICS 5), is above the closest tolerance of its
/// statistics, theory `rays`. Targets that are all given have no theory and change nothing.
Groundwork lay_groundwork(const Task& task);
/// The same by the physics that is asked for instead of the task's own.
Groundwork lay_groundwork(const Task& task, const PhysicsRequest& asked);

/// Number of exact dependencies between the m = 0 Zernikes and the spherical powers, judged by their slopes
/// (a constant height moves no ray).
int radial_overlap(const TermSet& terms);

/// Statistics to fit with values and tolerances; guides between them (default set only); and the ones held
/// out, which have theory's value and no tolerance (empty when a value is given).
struct TargetSets {
  std::vector<Target> fitted, guides, held_out;
  std::string theory;  ///< "geometric", "rays", "ghs", or "given"
  Warnings warnings;   ///< `target-missing`: statistics of the default set that the theory has no value for
};
/// Fitted, guides and held out: all that is asked of one surface.
std::vector<Target> all_targets(const TargetSets& targets);
/// Whether all of the task's statistics have a value: then no theory is asked.
bool targets_are_given(const Task& task);
TargetSets make_targets(const Task& task, const Groundwork& ground, int threads);

/// Warnings that follow from the specification alone.
Warnings scene_warnings(const Task& task, const Groundwork& ground, const TermSet& terms, double captured);

}  // namespace aberfit
