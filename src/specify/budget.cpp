#include "aberfit/specify/budget.h"

#include <fmt/format.h>

#include <cmath>
#include <regex>

#include "aberfit/core/text.h"

namespace aberfit {

// The percent as in target.statistics: no zeros in front or behind. A plane as results write it, with its
// unit.
const char* const kBudgetKey =
    R"((?:ee(0\.(?:0[0-9]{0,2}[1-9]|[0-9]{0,3}[1-9])|[1-9][0-9]?(?:\.[0-9]{0,3}[1-9])?)_(radius|diameter))"
    R"((?:@([-+]?[0-9.]+ ?(?:nm|um|mm|cm|m)))?|rms_height|scatter_rms|hew|strehl|tis|)"
    R"(mtf@([0-9.]+ ?/(?:um|mm|cm|m))))";

Budget parse_budget(const std::string& key, const std::string& bound) {
  static const std::regex key_form(kBudgetKey);
  static const std::regex bound_form(R"(\s*(<=|>=)\s*(\S.*?)\s*)");
  std::smatch part;
  if (!std::regex_match(key, part, key_form))
    throw UnitError(
        fmt::format("\"{}\" is no budget; expected ee<percent>_radius, ee<percent>_diameter, with "
                    "a plane like ee80_diameter@1mm, hew, strehl, mtf@<frequency> like mtf@20/mm, tis, "
                    "rms_height or scatter_rms",
                    key));
  Budget budget;
  budget.key = key;
  budget.bound = bound;
  const bool energy = part[1].matched || key == "hew";
  if (key == "hew") {
    budget.statistic = EncircledEnergyRadius{0.5, 0};
    budget.is_diameter = true;
  } else if (key == "strehl") {
    budget.of_light = StrehlRatio{};
  } else if (key == "tis") {
    budget.of_light = TotalScatter{};
  } else if (part[4].matched) {
    budget.of_light = ModulationTransfer{parse_quantity(part[4].str(), Dimension::kSpatialFrequency)};
  } else if (energy) {
    const double dz = part[3].matched ? parse_quantity(part[3].str(), Dimension::kLength) : 0;
    budget.statistic = EncircledEnergyRadius{std::stod(part[1].str()) / 100, dz};
    budget.is_diameter = part[2] == "diameter";
  } else if (key == "scatter_rms") {
    budget.statistic = ScatterRms{};
  }
  if (!std::regex_match(bound, part, bound_form))
    throw UnitError(
        fmt::format("\"{}\" is no bound; expected <= or >= and a quantity, e.g. \"<= 0.6 arcsec\"", bound));
  budget.at_most = part[1] == "<=";
  const std::string quantity = part[2];
  budget.dimension = budget.of_light ? Dimension::kFraction : kind_of(budget.statistic).dimension;
  if (energy) {  // whichever of the two it is a quantity of
    try {
      parse_quantity(quantity, Dimension::kLength);
    } catch (const UnitError&) {
      budget.dimension = Dimension::kAngle;
    }
  }
  // A share may be a plain number.
  const bool plain = budget.of_light && quantity.find_first_not_of("0123456789.eE+-") == std::string::npos;
  try {
    budget.limit = parse_quantity(quantity, plain ? Dimension::kNumber : budget.dimension);
  } catch (const UnitError& error) {
    throw UnitError(energy
                        ? fmt::format("{}; or a length: {}", error.what(), allowed_units(Dimension::kLength))
                        : std::string(error.what()));
  }
  if (!(budget.limit > 0)) throw UnitError(fmt::format("\"{}\" is not above zero", bound));
  if (budget.of_light && !(budget.limit < 1)) throw UnitError(fmt::format("\"{}\" is not below 1", bound));
  budget.unit = std::string(trimmed(quantity.substr(quantity.find_last_of("0123456789.") + 1)));
  return budget;
}

double of_light(const OfLight& what, const GeneralisedHarveyShack& mean,
                const GeneralisedHarveyShack& perfect, double focal_length, double wavelength,
                double aperture_radius) {
  if (std::holds_alternative<TotalScatter>(what)) return mean.tis();
  if (const auto* modulation = std::get_if<ModulationTransfer>(&what))
    return std::abs(mean.transfer(wavelength * focal_length * modulation->frequency, 0));
  // So near to the axis that the irradiance falls by less than 1e-6 there, of the core and of the scatter.
  constexpr double kNearAxis = 1e-4;
  const double r = kNearAxis * wavelength * focal_length / (2 * aperture_radius);
  return mean.at_plane(0).encircled_energy_slope(r) / perfect.at_plane(0).encircled_energy_slope(r);
}

double budgeted(const Budget& budget, double statistic, double focal_length) {
  if (budget.of_light) return statistic;
  const bool on_sky =
      budget.dimension == Dimension::kAngle && kind_of(budget.statistic).dimension == Dimension::kLength;
  return statistic * (budget.is_diameter ? 2 : 1) / (on_sky ? focal_length : 1);
}

std::string in_budget_unit(const Budget& budget, double value) {
  if (!std::isfinite(value)) return std::isnan(value) ? "none" : "infinite";
  if (budget.unit.empty()) return fmt::format("{:.5g}", value);
  return fmt::format("{:.5g} {}", value / unit_factor(budget.unit, budget.dimension), budget.unit);
}

std::string budget_name(const Budget& budget) {
  const std::size_t at = budget.key.find('@');
  const char* unit = budget.of_light ? "" : budget.dimension == Dimension::kAngle ? "_rad" : "_m";
  return budget.key.substr(0, at) + unit + (at == std::string::npos ? "" : budget.key.substr(at));
}

}  // namespace aberfit
