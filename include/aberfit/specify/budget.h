#pragma once
#include <string>

#include "aberfit/core/units.h"
#include "aberfit/focus/statistic.h"

namespace aberfit {

/// A limit on a statistic, as a specification says it: "ee80_diameter": "<= 0.6 arcsec".
struct Budget {
  std::string key;  ///< as typed: ee<percent>_radius, ee<percent>_diameter, both with a plane "@1mm" if it is
                    ///< not the focus; rms_height; scatter_rms
  std::string bound;  ///< as typed: <= or >=, a number and its unit
  Statistic statistic = RmsHeight{};
  bool is_diameter = false;                  ///< twice the statistic, a radius
  bool at_most = true;                       ///< <=
  double limit = 0;                          ///< [m] or [rad], > 0
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
/// `value` [m] or [rad] in the unit of the bound: "0.5432 arcsec".
std::string in_budget_unit(const Budget& budget, double value);
/// "ee80_diameter_rad": the key with the SI unit of the limit, as results have it.
std::string budget_name(const Budget& budget);

}  // namespace aberfit
