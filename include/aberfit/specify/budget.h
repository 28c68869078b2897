#pragma once
#include <optional>
#include <string>
#include <variant>

#include "aberfit/core/units.h"
#include "aberfit/focus/statistic.h"
#include "aberfit/theory/generalised_harvey_shack.h"

namespace aberfit {

/// Properties of the mean light in the focus that are no statistics of rays (PHYSICS 2, 6).
struct StrehlRatio {};   ///< irradiance on the axis over that of the perfect parabola
struct TotalScatter {};  ///< TIS: share of the light that is scattered, 1 - core
/// Modulus of the transfer function at a frequency of the image, averaged over direction; 1 at 0.
struct ModulationTransfer {
  double frequency = 0;  ///< [cycles/m]
};
using OfLight = std::variant<StrehlRatio, TotalScatter, ModulationTransfer>;

/// A limit on a statistic, as a specification says it: "ee80_diameter": "<= 0.6 arcsec".
struct Budget {
  /// As typed: ee<percent>_radius, ee<percent>_diameter, both with a plane "@1mm" if it is not the focus; hew
  /// (half-energy width, ee50_diameter); rms_height; scatter_rms; strehl; tis; mtf@<frequency>.
  std::string key;
  std::string bound;  ///< as typed: <= or >=, a number and its unit
  Statistic statistic = RmsHeight{};
  std::optional<OfLight> of_light;           ///< instead of `statistic`
  bool is_diameter = false;                  ///< twice the statistic, a radius
  bool at_most = true;                       ///< <=
  double limit = 0;                          ///< [m], [rad] or [1], > 0
  Dimension dimension = Dimension::kLength;  ///< of the limit; a length in the focus as angle is length/f
  std::string unit;                          ///< of the limit as typed
};

/// Regular expression (ECMA) of the keys that budgets may have.
extern const char* const kBudgetKey;

/// Throws UnitError that says what is allowed for a key or a bound that is none.
Budget parse_budget(const std::string& key, const std::string& bound);

/// What the budget limits, of the statistic's value [its SI unit]: [m] or [rad], as `limit`. focal_length:
/// [m], whose inverse is the plate scale.
double budgeted(const Budget& budget, double statistic, double focal_length);
/// The property of that mean light. perfect: of the parabola without roughness in the same aperture and
/// light.
double of_light(const OfLight& what, const GeneralisedHarveyShack& mean,
                const GeneralisedHarveyShack& perfect, double focal_length, double wavelength,
                double aperture_radius);
/// `value` [m] or [rad] in the unit of the bound: "0.5432 arcsec".
std::string in_budget_unit(const Budget& budget, double value);
/// "ee80_diameter_rad": the key with the SI unit of the limit, as results have it.
std::string budget_name(const Budget& budget);

}  // namespace aberfit
