#pragma once
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "aberfit/core/units.h"

namespace aberfit {

/// The focal statistics of PHYSICS 2. dz: plane, offset from z = f [m].
struct EncircledEnergyRadius {
  double fraction = 0.9;  ///< in (0, 1)
  double dz = 0;          ///< [m]
};
/// Full width [m] at half maximum of N(z), the share of light inside a fixed ring. The ring radius is the
/// encircled-energy radius of the same data at z = f, or a given length.
struct RingFwhm {
  double ring_fraction = 0.9;
  std::optional<double> ring_radius;  ///< [m], wins over ring_fraction
};
/// N(z) itself: share of the light inside `ring_radius` at plane dz.
struct RingThrough {
  double ring_radius = 0;  ///< [m]
  double dz = 0;           ///< [m]
  bool is_point = false;   ///< one point of a profile, named by its plane; else `ee_within`, by its radius
};
struct ScatterRms {};   ///< RMS angle between a ray and its nominal ray [rad]
struct ScatterMean {};  ///< mean of the same angle [rad]
/// FWHM [m] of the focal-plane line spread profile, mean of x and y, smoothed by a Gaussian kernel of
/// standard deviation `bandwidth`.
struct SpotFwhm {
  double bandwidth = 0;  ///< [m]
};
struct RmsRadius {
  double dz = 0;  ///< [m]
};
struct RmsHeight {};  ///< RMS of the surface error over the pupil, mean removed [m]
/// Of light alone: highest irradiance in the plane z = f, wherever it is, over that of the perfect parabola
/// in the same aperture and light, which is on the axis. Tilt does not change it.
struct StrehlRatio {};
/// Of light alone, at z = f: modulus of the transfer function at a frequency of the image, of its mean over
/// direction; 1 at 0.
struct ModulationTransfer {
  double frequency = 0;  ///< [cycles/m]
};

/// Of light alone: share of it in a square about the axis, the mean over squares turned all ways (as
/// MeanSpot::ensquared_energy).
struct EnsquaredThrough {
  double side = 0;  ///< [m]
  double dz = 0;    ///< [m]
};

using Statistic =
    std::variant<EncircledEnergyRadius, RingFwhm, RingThrough, ScatterRms, ScatterMean, SpotFwhm, RmsRadius,
                 RmsHeight, StrehlRatio, ModulationTransfer, EnsquaredThrough>;

/// What there is to know of a kind of statistic, said here and nowhere else.
struct StatisticKind {
  std::string key;      ///< in target.statistics; of encircled energies "ee", before their percent
  bool has_key;         ///< a study can name it by its key alone
  Dimension dimension;  ///< of its value
  bool in_planes;       ///< in every plane that is asked for
  bool in_waves;        ///< exists in a diffracted focus
  bool in_rays;         ///< exists in a focus of geometric rays
  bool is_moment;       ///< an integral over height and slope of the surface, not a count of rays
};
const StatisticKind& kind_of(const Statistic& statistic);
/// Shares, by number: light within a radius or a square, Strehl ratio, transfer; points of a profile are
/// none.
bool is_share(const Statistic& statistic);
/// Offset from z = f of the plane that light is seen in [m]; nothing for what looks through planes
/// (RingFwhm), at the surface, or is of rays alone (RmsRadius).
std::optional<double> plane_of_light(const Statistic& statistic);
/// By the key of a study, ee<percent> among them. Throws std::invalid_argument for a key of no statistic.
const StatisticKind& kind_of_key(const std::string& key);
/// Keys that a study may name, without those of encircled energies.
std::vector<std::string> request_keys();

/// What the unit suffix of a statistic's name says: `..._m...` a length, `..._rad...` an angle, else a
/// number.
Dimension dimension_of_name(const std::string& name);
/// The name without that suffix, for values that carry their own unit: ee50_radius_m@-1mm ->
/// ee50_radius@-1mm.
std::string name_without_unit(const std::string& name);

/// Name with its SI unit as used in every result: `ee50_radius_m`, `ee50_radius_m@-1mm`, `ring_fwhm_m`,
/// `ring_fwhm_m@ring=ee50`, `ee_within_10um@0.5mm`, `ring_through@0.5mm`, `scatter_rms_rad`,
/// `scatter_mean_rad`, `spot_fwhm_m`, `rms_radius_m`, `rms_height_m`, `strehl`, `mtf@20/mm`,
/// `ensquared_within_20um`. Fractions and planes print with as many digits as they need, at most 6
/// significant ones.
std::string statistic_name(const Statistic& statistic);

/// One thing to be matched: a statistic, what it should be, and how closely.
struct Target {
  Statistic statistic;
  double value = 0;           ///< in the statistic's unit
  double standard_error = 0;  ///< sampling error of `value`, 0 for closed forms
  double tolerance = 0;       ///< absolute, in the statistic's unit, > 0
  /// What a relative tolerance or margin of this target is relative to, in the statistic's unit; 0: |value|.
  double scale = 0;
  /// Of an EncircledEnergyRadius whose curve of encircled energy is known: r dE/dr [1] there, >= 0. It is
  /// then met and judged in light, see `aim_of`.
  std::optional<double> curve_slope = {};

  double relative_to() const { return scale > 0 ? scale : value < 0 ? -value : value; }
  /// That `standard_error` is known by: infinite where it is not estimated from a few samples.
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
};

/// The least slope r dE/dr that the tolerance of an encircled-energy target goes by. Where the curve is
/// flatter, between core and halo, a radius says little: 1 % of the radius may be 0.05 % of the light. There
/// a margin of 1 % asks for 0.35 % of the light; a Gaussian spot has 0.36 at 20 % and 0.46 at 90 %.
inline constexpr double kFlattestCurve = 0.35;

/// What a surface has to meet for `target`. A radius whose curve is known is met in light: the share of the
/// light inside the target's radius (RingThrough) has to be the fraction, within the tolerance, relative to
/// max(r dE/dr, kFlattestCurve). Everything else is met as it is, `ee_within` and `ensquared_within` relative
/// to kFlattestCurve, Strehl ratios and transfer functions to themselves or to that, whichever is larger.
Target aim_of(const Target& target);
std::vector<Target> aims_of(const std::vector<Target>& targets);
/// What they are targets of, in their order.
std::vector<Statistic> statistics_of(const std::vector<Target>& targets);

/// r dE/dr of a round Gaussian spot at the radius that holds `fraction` in (0, 1): 2 (1 - p) ln(1/(1 - p)).
double gaussian_curve_slope(double fraction);
/// Its standard deviation in each axis where `radius` holds `fraction` in (0, 1): r/sqrt(-2 ln(1 - p)).
double gaussian_sigma(double radius, double fraction);
/// Its ee90 in units of that: sqrt(2 ln 10).
inline constexpr double kGaussianEe90 = 2.14596602628934724;

}  // namespace aberfit
