#pragma once
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "aberfit/core/units.h"
#include "aberfit/focus/statistic.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/roughness/psd_derivative.h"
#include "aberfit/theory/light_property.h"

namespace aberfit {

// Quantities of the surface itself (PHYSICS 3), from its PSD alone, without aperture and diffraction.

/// RMS height [m] of the frequencies from f_min to f_max, without subtraction of a mean as in RmsHeight.
struct HeightInBand {
  double f_min = 0, f_max = std::numeric_limits<double>::infinity();  ///< [cycles/m]
};
/// RMS slope [1] per axis of the frequencies from f_min to f_max, s = sqrt(slope variance/2).
struct SlopeInBand {
  double f_min = 0, f_max = std::numeric_limits<double>::infinity();  ///< [cycles/m]
};
/// RMS difference [m] of two heights at that distance: root of the structure function D(r) = 2 (C(0) - C(r)).
struct HeightDifference {
  double separation = 0;  ///< [m]
};
using OfSurface = std::variant<HeightInBand, SlopeInBand, HeightDifference>;

/// Returns the quantity; infinite if the integral diverges.
double of_surface(const OfSurface& what, const RadialPsd& psd);
/// Returns d ln(of_surface)/dp, exact; NaN where of_surface is 0 or infinite.
double of_surface_change(const OfSurface& what, const RadialPsd& psd, const PsdDerivative& derivative);

/// A limit on a statistic, as written in a specification: "ee80_diameter": "<= 0.6 arcsec".
struct Budget {
  std::string key;    ///< as typed, see budget_keys
  std::string bound;  ///< the bound as typed: <= or >=, a number and its unit
  Statistic statistic = RmsHeight{};
  std::optional<LightProperty> of_light;  ///< used instead of `statistic`
  std::optional<OfSurface> of_surface;    ///< used instead of `statistic`
  bool is_diameter = false;               ///< the limit is for twice the statistic, a radius
  bool is_squared = false;                ///< the limit is for the square of a HeightDifference, D itself
  bool at_most = true;                    ///< true: <=; false: >=
  double limit = 0;                       ///< [m], [m^2], [rad], [1/sr] or [1], > 0; see in_wavelengths
  bool in_wavelengths = false;            ///< `limit` is still a number of wavelengths
  /// dimension of the limit; a length in the focus as an angle is length/f
  Dimension dimension = Dimension::kLength;
  std::string unit;      ///< unit of the limit as typed
  double unit_size = 1;  ///< size of that unit in SI units
};

/// A kind of budget key.
struct BudgetKey {
  std::string regex;   ///< ECMA regular expression for the whole key
  std::string sample;  ///< an example of such a key
};
/// Returns all kinds: ee<percent>_radius, ee<percent>_diameter, ensquared<percent>_side and fwhm, all with a
/// plane "@1mm" if it is not the focus; hew (half-energy width, ee50_diameter); strehl; tis; mtf@<frequency>;
/// pssn@<r0 at 500 nm>, without it 15 cm; bsdf@<angle>; rms_height and rms_slope, both with a band
/// "@10/m-100/m" or without; structure@<separation>; scatter_rms.
const std::vector<BudgetKey>& budget_keys();

/// Parses a key and its bound. Throws UnitError with the allowed forms if either is invalid.
/// Widths, radii and sides are lengths or angles on the sky; heights may also be "lambda/20" and be marked
/// RMS ("5 nm RMS"); slopes are numbers or angles. structure@... is the root of D if the bound is a length, D
/// itself if it is an area ("25 nm^2"). Fractions are numbers below 1 or percent; a BSDF is a number or in
/// "1/sr".
Budget parse_budget(const std::string& key, const std::string& bound);
/// Returns the budget with a limit in wavelengths converted to [m].
Budget at_wavelength(Budget budget, double wavelength);

/// Converts the value of the statistic or property [its SI unit] to the quantity that `limit` bounds.
/// focal_length [m]: its inverse is the plate scale.
double budgeted(const Budget& budget, double value, double focal_length);
/// Returns `value` [as limit] in the unit of the bound: "0.5432 arcsec", "lambda/18.3".
std::string in_budget_unit(const Budget& budget, double value);
/// Returns the key with the SI unit of the limit, as in results: "ee80_diameter_rad".
std::string budget_name(const Budget& budget);
/// Returns true if a smoother mirror has a smaller value: all but Strehl ratio, MTF and PSSN.
bool is_less_of_smoother(const Budget& budget);

}  // namespace aberfit
