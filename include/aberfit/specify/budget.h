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

// Numbers of the surface itself (PHYSICS 3): of its PSD, without an aperture and without light.

/// RMS height [m] of the frequencies from f_min to f_max. Its mean is not taken off, as RmsHeight's is.
struct HeightInBand {
  double f_min = 0, f_max = std::numeric_limits<double>::infinity();  ///< [cycles/m]
};
/// RMS slope [1] of those frequencies per axis, s = sqrt(slope variance/2).
struct SlopeInBand {
  double f_min = 0, f_max = std::numeric_limits<double>::infinity();  ///< [cycles/m]
};
/// RMS difference [m] of two heights so far apart: the root of the structure function D(r) = 2 (C(0) - C(r)).
struct HeightDifference {
  double separation = 0;  ///< [m]
};
using OfSurface = std::variant<HeightInBand, SlopeInBand, HeightDifference>;

/// Infinite where the integral does not exist.
double of_surface(const OfSurface& what, const RadialPsd& psd);
/// d ln(of_surface)/dp, exact; NaN where it is 0 or infinite.
double of_surface_change(const OfSurface& what, const RadialPsd& psd, const PsdDerivative& derivative);

/// A limit on a statistic, as a specification says it: "ee80_diameter": "<= 0.6 arcsec".
struct Budget {
  std::string key;    ///< as typed, see budget_keys
  std::string bound;  ///< as typed: <= or >=, a number and its unit
  Statistic statistic = RmsHeight{};
  std::optional<LightProperty> of_light;     ///< instead of `statistic`
  std::optional<OfSurface> of_surface;       ///< the same
  bool is_diameter = false;                  ///< twice the statistic, a radius
  bool is_squared = false;                   ///< the square of a HeightDifference, D itself
  bool at_most = true;                       ///< <=
  double limit = 0;                          ///< [m], [m^2], [rad], [1/sr] or [1], > 0; see in_wavelengths
  bool in_wavelengths = false;               ///< `limit` is still a number of wavelengths
  Dimension dimension = Dimension::kLength;  ///< of the limit; a length in the focus as angle is length/f
  std::string unit;                          ///< of the limit as typed
  double unit_size = 1;                      ///< of that unit in SI units
};

/// A kind of key that budgets may have.
struct BudgetKey {
  std::string regex;   ///< ECMA, of the whole key
  std::string sample;  ///< a key of that kind
};
/// All of them: ee<percent>_radius, ee<percent>_diameter, ensquared<percent>_side and fwhm, all with a plane
/// "@1mm" if it is not the focus; hew (half-energy width, ee50_diameter); strehl; tis; mtf@<frequency>;
/// pssn@<r0 at 500 nm>, without it 15 cm; bsdf@<angle>; rms_height and rms_slope, both with a band
/// "@10/m-100/m" or without; structure@<separation>; scatter_rms.
const std::vector<BudgetKey>& budget_keys();

/// Throws UnitError that says what is allowed for a key or a bound that is none. Widths, radii and sides are
/// bounded as a length or an angle on the sky; heights also as "lambda/20"; heights may be called RMS ("5 nm
/// RMS"); slopes are numbers or angles; structure@... is its root where the bound is a length, itself where
/// it is an area ("25 nm^2"); shares are plain numbers below 1 or percent, a BSDF a plain number or in
/// "1/sr".
Budget parse_budget(const std::string& key, const std::string& bound);
/// With a limit that was typed in wavelengths in [m].
Budget at_wavelength(Budget budget, double wavelength);

/// What the budget limits, of the statistic's or property's value [its SI unit], as `limit`. focal_length:
/// [m], whose inverse is the plate scale.
double budgeted(const Budget& budget, double value, double focal_length);
/// `value` [as limit] in the unit of the bound: "0.5432 arcsec", "lambda/18.3".
std::string in_budget_unit(const Budget& budget, double value);
/// "ee80_diameter_rad": the key with the SI unit of the limit, as results have it.
std::string budget_name(const Budget& budget);
/// Whether a smoother mirror has a smaller value: all but Strehl ratio, MTF and PSSN.
bool is_less_of_smoother(const Budget& budget);

}  // namespace aberfit
