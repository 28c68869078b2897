#pragma once
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "aberfit/core/units.h"

namespace aberfit {

/// Who can compute a statistic.
enum class Physics { kBoth = 1, kRays, kWaves };
enum class FocalPlane {
  kFocus = 1,  ///< z = f
  kGiven,      ///< z = f + dz, its member
  kThrough,    ///< many planes; the value is a length along the axis
  kSurface,    ///< none: a moment, an integral over surface height and slope, not a count of rays
};
/// The physical meaning of a value. It decides the requirement on a surface (`aim_of`) and how the values of
/// several wavelengths combine.
enum class Measure {
  kSize = 1,    ///< a length or an angle; of a band that of the mean by energy
  kHalfWidth,   ///< a width at half maximum, which a band does not have
  kEnergy,      ///< a fraction: the energy inside an area
  kIrradiance,  ///< a fraction of the perfect mirror's irradiance, by which wavelengths count
  kTransfer,    ///< another fraction
};
/// Properties of one kind of statistic. None may be left out.
struct StatisticKind {
  std::string_view key;  ///< key in target.statistics; "ee" of kPercent, before the percentage
  Dimension dimension;   ///< of the value
  Physics physics;
  FocalPlane plane;
  Measure measure;

  constexpr bool in_waves() const { return physics != Physics::kRays; }
  constexpr bool in_rays() const { return physics != Physics::kWaves; }
  constexpr bool is_moment() const { return plane == FocalPlane::kSurface; }
};
/// An option that a study gives with a statistic, in addition to value, tolerance and planes.
struct StudyOption {
  enum Form {
    kNone,
    kPercent,  ///< the energy fraction, in the key: ee<percent>
    kRing,     ///< a ring, by its radius or its fraction
    kWidth,    ///< one length, optional
    kPlaces,   ///< positive numbers, each for a statistic of its own
  } form = kNone;
  const char *key = "", *text = "", *example = "";
  Dimension dimension = Dimension::kLength;
  const char* one = "";  ///< kPlaces: the singular of its key

  static constexpr StudyOption places(const char* key, const char* one, const char* text, const char* example,
                                      Dimension dimension = Dimension::kLength) {
    return {kPlaces, key, text, example, dimension, one};
  }
};
/// The options of one statistic.
struct StatisticOptions {
  double dz = 0;                      ///< [m]
  double fraction = 0.9;              ///< kPercent, kRing
  std::optional<double> ring_radius;  ///< kRing [m]
  double number = 0;                  ///< kWidth, kPlaces
};

/// The focal statistics of PHYSICS 2. dz is the offset of the plane from z = f [m].
struct EncircledEnergyRadius {
  static constexpr StatisticKind kKind{"ee", Dimension::kLength, Physics::kBoth, FocalPlane::kGiven,
                                       Measure::kSize};
  static constexpr StudyOption kOption{StudyOption::kPercent};
  double fraction = 0.9;  ///< in (0, 1)
  double dz = 0;          ///< [m]
  static EncircledEnergyRadius with(const StatisticOptions& o) { return {o.fraction, o.dz}; }
};
/// Full width at half maximum [m] of N(z), the encircled energy of a fixed ring as a function of z. The ring
/// radius is a given length, or the encircled-energy radius of the same data at z = f.
struct RingFwhm {
  static constexpr StatisticKind kKind{"ring_fwhm", Dimension::kLength, Physics::kBoth, FocalPlane::kThrough,
                                       Measure::kHalfWidth};
  static constexpr StudyOption kOption{StudyOption::kRing};
  double ring_fraction = 0.9;
  std::optional<double> ring_radius;  ///< [m]; replaces ring_fraction when given
  static RingFwhm with(const StatisticOptions& o) { return {o.fraction, o.ring_radius}; }
};
/// Encircled energy N(z) of `ring_radius` at plane dz, as a fraction.
struct RingThrough {
  static constexpr StatisticKind kKind{"ee_within", Dimension::kFraction, Physics::kBoth, FocalPlane::kGiven,
                                       Measure::kEnergy};
  static constexpr StudyOption kOption =
      StudyOption::places("radii", "radius", "radii of the discs about the axis [m]", "[\"10 um\"]");
  double ring_radius = 0;  ///< [m]
  double dz = 0;           ///< [m]
  bool is_point = false;  ///< a point of a profile, named by its plane; else `ee_within`, named by its radius
  static RingThrough with(const StatisticOptions& o) { return {o.number, o.dz}; }
};
struct ScatterRms {  ///< RMS angle between a ray and its nominal ray [rad]
  static constexpr StatisticKind kKind{"scatter_rms", Dimension::kAngle, Physics::kBoth, FocalPlane::kSurface,
                                       Measure::kSize};
};
struct ScatterMean {  ///< mean of the same angle [rad]
  static constexpr StatisticKind kKind{"scatter_mean", Dimension::kAngle, Physics::kBoth,
                                       FocalPlane::kSurface, Measure::kSize};
};
/// FWHM [m] of the line spread function in the focal plane, mean of x and y. A Gaussian kernel of standard
/// deviation `bandwidth` smooths it.
struct SpotFwhm {
  static constexpr StatisticKind kKind{"spot_fwhm", Dimension::kLength, Physics::kBoth, FocalPlane::kFocus,
                                       Measure::kHalfWidth};
  static constexpr StudyOption kOption{
      StudyOption::kWidth, "bandwidth",
      "standard deviation of the Gaussian kernel that smooths the line spread profile [m]", "\"5 um\""};
  double bandwidth = 0;  ///< [m]
  static SpotFwhm with(const StatisticOptions& o) { return {o.number}; }
};
struct RmsRadius {
  static constexpr StatisticKind kKind{"rms_radius", Dimension::kLength, Physics::kRays, FocalPlane::kGiven,
                                       Measure::kSize};
  double dz = 0;  ///< [m]
  static RmsRadius with(const StatisticOptions& o) { return {o.dz}; }
};
struct RmsHeight {  ///< RMS of the surface error over the pupil, about its mean [m]
  static constexpr StatisticKind kKind{"rms_height", Dimension::kLength, Physics::kBoth, FocalPlane::kSurface,
                                       Measure::kSize};
};
/// Highest irradiance anywhere in the plane z = f, over the axial irradiance of the perfect parabola with the
/// same aperture and wavelengths. Tilt does not change it.
struct StrehlRatio {
  static constexpr StatisticKind kKind{"strehl", Dimension::kFraction, Physics::kWaves, FocalPlane::kFocus,
                                       Measure::kIrradiance};
};
/// Modulus of the optical transfer function at a spatial frequency of the image, in the plane z = f. The
/// transfer function is averaged over direction first; it is 1 at zero.
struct ModulationTransfer {
  static constexpr StatisticKind kKind{"mtf", Dimension::kFraction, Physics::kWaves, FocalPlane::kFocus,
                                       Measure::kTransfer};
  static constexpr StudyOption kOption =
      StudyOption::places("frequencies", "frequency", "spatial frequencies in the image [cycles/m]",
                          "[\"20 /mm\"]", Dimension::kSpatialFrequency);
  double frequency = 0;  ///< [cycles/m]
  static ModulationTransfer with(const StatisticOptions& o) { return {o.number}; }
};
/// Ensquared energy of a square about the axis, as a fraction. It is the mean over all orientations of the
/// square (see MeanSpot::ensquared_energy).
struct EnsquaredThrough {
  static constexpr StatisticKind kKind{"ensquared_within", Dimension::kFraction, Physics::kWaves,
                                       FocalPlane::kGiven, Measure::kEnergy};
  static constexpr StudyOption kOption = StudyOption::places(
      "sides", "side",
      "sides of the squares about the axis [m]; each value is the mean over all orientations of the square",
      "[\"15 um\"]");
  double side = 0;  ///< [m]
  double dz = 0;    ///< [m]
  static EnsquaredThrough with(const StatisticOptions& o) { return {o.number, o.dz}; }
};

template <typename S>
concept RayKind = !S::kKind.in_waves();
template <typename S>
concept WaveKind = !S::kKind.in_rays();
template <typename S>
concept MomentKind = S::kKind.is_moment();
template <typename S>
concept NoMoment = !MomentKind<S>;
template <typename S>
concept HasPlane = std::is_same_v<decltype(S::dz), double>;
template <typename S>
concept HasOption = std::is_same_v<decltype(S::kOption), const StudyOption>;
/// Requirements on a statistic type: every field of its kind is set; it has dz if its kind says so, an option
/// for every other member, and `with` if it has any member.
template <typename S>
concept FocalStatistic = S::kKind.measure != Measure{} &&
                         HasPlane<S> == (S::kKind.plane == FocalPlane::kGiven) &&
                         (HasOption<S> || std::is_empty_v<S> || sizeof(S) == sizeof(double) * HasPlane<S>)&&(
                             std::is_empty_v<S> || std::is_same_v<decltype(S::with({})), S>);
template <FocalStatistic... S>
using AnyStatistic = std::variant<S...>;
using Statistic =
    AnyStatistic<EncircledEnergyRadius, RingFwhm, RingThrough, ScatterRms, ScatterMean, SpotFwhm, RmsRadius,
                 RmsHeight, StrehlRatio, ModulationTransfer, EnsquaredThrough>;

const StatisticKind& kind_of(const Statistic& statistic);
/// Returns whether the value is a fraction: encircled or ensquared energy (no profile points), Strehl ratio,
/// transfer.
bool is_share(const Statistic& statistic);
/// Offset from z = f of the plane of a statistic of the irradiance [m]. Returns nothing for a statistic
/// through many planes (RingFwhm), of the surface, or of rays alone (RmsRadius).
std::optional<double> plane_of_light(const Statistic& statistic);
/// Finds a kind by its key in a study, e.g. ee<percent>. Throws std::invalid_argument for an unknown key.
const StatisticKind& kind_of_key(const std::string& key);
/// The option that a study gives with a statistic, and the statistic of a key with its options. They throw as
/// kind_of_key.
const StudyOption& option_of_key(const std::string& key);
Statistic statistic_of_key(const std::string& key, const StatisticOptions& options);
/// Keys that a study may name, without those of encircled-energy radii.
std::vector<std::string> request_keys();

/// Standard deviation [m] per axis of a round Gaussian spot with this value of the statistic; absent where
/// the value does not determine a size. focal_length: [m].
std::optional<double> spot_sigma(const Statistic& statistic, double value, double focal_length);
/// Radius [m] in focus of the light that decides this value. Infinite: of all; 0: of no more than others.
double deciding_radius(const Statistic& statistic, double value);

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
