#pragma once
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "aberfit/core/units.h"

namespace aberfit {

/// The focal statistics of PHYSICS 2. dz is the offset of the plane from z = f [m].
struct EncircledEnergyRadius {
  double fraction = 0.9;  ///< in (0, 1)
  double dz = 0;          ///< [m]
};
/// Full width at half maximum [m] of N(z), the encircled energy of a fixed ring as a function of z. The ring
/// radius is a given length, or the encircled-energy radius of the same data at z = f.
struct RingFwhm {
  double ring_fraction = 0.9;
  std::optional<double> ring_radius;  ///< [m]; replaces ring_fraction when given
};
/// Encircled energy N(z) of `ring_radius` at plane dz, as a fraction.
struct RingThrough {
  double ring_radius = 0;  ///< [m]
  double dz = 0;           ///< [m]
  bool is_point = false;  ///< a point of a profile, named by its plane; else `ee_within`, named by its radius
};
struct ScatterRms {};   ///< RMS angle between a ray and its nominal ray [rad]
struct ScatterMean {};  ///< mean of the same angle [rad]
/// FWHM [m] of the line spread function in the focal plane, mean of x and y. A Gaussian kernel of standard
/// deviation `bandwidth` smooths it.
struct SpotFwhm {
  double bandwidth = 0;  ///< [m]
};
struct RmsRadius {
  double dz = 0;  ///< [m]
};
struct RmsHeight {};  ///< RMS of the surface error over the pupil, about its mean [m]
/// Wave optics only: highest irradiance anywhere in the plane z = f, over the axial irradiance of the perfect
/// parabola with the same aperture and wavelengths. Tilt does not change it.
struct StrehlRatio {};
/// Wave optics only, at z = f: modulus of the optical transfer function at a spatial frequency of the image.
/// The transfer function is averaged over direction first; it is 1 at zero.
struct ModulationTransfer {
  double frequency = 0;  ///< [cycles/m]
};

/// Wave optics only: ensquared energy of a square about the axis, as a fraction. It is the mean over all
/// orientations of the square (see MeanSpot::ensquared_energy).
struct EnsquaredThrough {
  double side = 0;  ///< [m]
  double dz = 0;    ///< [m]
};

using Statistic =
    std::variant<EncircledEnergyRadius, RingFwhm, RingThrough, ScatterRms, ScatterMean, SpotFwhm, RmsRadius,
                 RmsHeight, StrehlRatio, ModulationTransfer, EnsquaredThrough>;

/// Properties of one kind of statistic. This table is their only definition.
struct StatisticKind {
  std::string key;      ///< key in target.statistics; "ee" for encircled-energy radii, before the percentage
  bool has_key;         ///< whether a study can name it by its key alone
  Dimension dimension;  ///< dimension of its value
  bool in_planes;       ///< whether it is evaluated in every requested plane
  bool in_waves;        ///< whether wave optics has it
  bool in_rays;         ///< whether geometric rays have it
  bool is_moment;       ///< whether it is an integral over surface height and slope, not a count of rays
};
const StatisticKind& kind_of(const Statistic& statistic);
/// Returns whether the value is a fraction: encircled or ensquared energy (no profile points), Strehl ratio,
/// transfer.
bool is_share(const Statistic& statistic);
/// Offset from z = f of the plane of a statistic of the irradiance [m]. Returns nothing for a statistic
/// through many planes (RingFwhm), of the surface, or of rays alone (RmsRadius).
std::optional<double> plane_of_light(const Statistic& statistic);
/// Finds a kind by its key in a study, e.g. ee<percent>. Throws std::invalid_argument for an unknown key.
const StatisticKind& kind_of_key(const std::string& key);
/// Keys that a study may name, without those of encircled-energy radii.
std::vector<std::string> request_keys();

/// Dimension from the unit suffix of a statistic's name: `..._m...` is a length, `..._rad...` an angle,
/// anything else a number.
Dimension dimension_of_name(const std::string& name);
/// The name without that suffix, for values with a unit: ee50_radius_m@-1mm becomes ee50_radius@-1mm.
std::string name_without_unit(const std::string& name);

/// Name with SI unit, as in every result: `ee50_radius_m`, `ee50_radius_m@-1mm`, `ring_fwhm_m`,
/// `ring_fwhm_m@ring=ee50`, `ee_within_10um@0.5mm`, `ring_through@0.5mm`, `scatter_rms_rad`,
/// `scatter_mean_rad`, `spot_fwhm_m`, `rms_radius_m`, `rms_height_m`, `strehl`, `mtf@20/mm`,
/// `ensquared_within_20um`. Fractions and planes have at most 6 significant digits.
std::string statistic_name(const Statistic& statistic);

/// Name and unit of a statistic in a study. The displayed number is the value times `per_si`.
struct AskedAs {
  std::string name;   ///< "ee80_diameter", "hew"; empty: name of the statistic
  std::string unit;   ///< "arcsec"; empty: a unit that suits the value
  double per_si = 1;  ///< 2 for a diameter whose statistic is a radius

  bool as_it_is() const { return name.empty() && unit.empty(); }
};

/// One requirement: a statistic, its required value and the tolerance.
struct Target {
  Statistic statistic;
  double value = 0;           ///< in the statistic's unit
  double standard_error = 0;  ///< sampling error of `value`, 0 for closed forms
  double tolerance = 0;       ///< absolute, in the statistic's unit, > 0
  /// Reference of relative tolerances and margins, in the statistic's unit; 0: |value|.
  double scale = 0;
  /// r dE/dr [1] of an EncircledEnergyRadius whose encircled-energy curve is known, >= 0. Such a target is
  /// fitted and judged in energy, see `aim_of`.
  std::optional<double> curve_slope = {};
  AskedAs asked = {};

  double relative_to() const { return scale > 0 ? scale : value < 0 ? -value : value; }
  /// degrees of freedom of `standard_error`; infinite unless it is estimated from a few samples
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
};

/// Lower limit of the slope r dE/dr that converts the tolerance of a radius into energy. Where the curve is
/// flatter, between core and halo, 1 % of the radius may be only 0.05 % of the energy. There a tolerance of 1
/// % means 0.35 % of the energy. A Gaussian spot has the slopes 0.36 at 20 % and 0.46 at 90 %.
inline constexpr double kFlattestCurve = 0.35;

/// The requirement on a surface that follows from `target`. A radius with a known curve becomes an encircled
/// energy: the fraction inside the target's radius (RingThrough) must equal the target's fraction. Its
/// tolerance is relative to max(r dE/dr, kFlattestCurve). Other statistics stay as they are. Tolerances of
/// `ee_within` and `ensquared_within` are relative to kFlattestCurve, those of Strehl ratios and transfer
/// functions to the larger of the value and kFlattestCurve.
Target aim_of(const Target& target);
std::vector<Target> aims_of(const std::vector<Target>& targets);
/// The statistics of the targets, in their order.
std::vector<Statistic> statistics_of(const std::vector<Target>& targets);

/// r dE/dr of a circular Gaussian spot at the radius that holds `fraction` p in (0, 1): -2 (1 - p) ln(1 - p).
double gaussian_curve_slope(double fraction);
/// Standard deviation per axis of a circular Gaussian spot whose `radius` holds `fraction` p in (0, 1):
/// r/sqrt(-2 ln(1 - p)).
double gaussian_sigma(double radius, double fraction);
/// The ee90 radius of that spot over its standard deviation: sqrt(2 ln 10).
inline constexpr double kGaussianEe90 = 2.14596602628934724;

}  // namespace aberfit
