#include "aberfit/specify/budget.h"

#include <fmt/format.h>

#include <cmath>
#include <regex>

#include "aberfit/core/constants.h"
#include "aberfit/core/overloaded.h"
#include "aberfit/core/text.h"

namespace aberfit {
namespace {

// Percentage as in target.statistics, without leading or trailing zeros.
constexpr const char* kPercent =
    R"((0\.(?:0[0-9]{0,2}[1-9]|[0-9]{0,3}[1-9])|[1-9][0-9]?(?:\.[0-9]{0,3}[1-9])?))";
// A plane with its unit, as results write it.
constexpr const char* kPlane = R"((?:@([-+]?[0-9.]+ ?(?:nm|um|mm|cm|m)))?)";
constexpr const char* kLengthOfKey = R"(([0-9.]+ ?(?:nm|um|mm|cm|m)))";
constexpr const char* kFrequencyOfKey = R"(([0-9.]+ ?/(?:um|mm|cm|m)))";
constexpr const char* kAngleOfKey = R"(([0-9.]+ ?(?:deg|rad|mrad|urad|arcmin|arcsec)))";

double length_of(const std::string& text) { return parse_quantity(text, Dimension::kLength); }
double frequency_of(const std::string& text) { return parse_quantity(text, Dimension::kSpatialFrequency); }
double plane_of(const std::ssub_match& text) { return text.matched ? length_of(text.str()) : 0; }
double share_of(const std::string& percent) { return std::stod(percent) / 100; }

double above_zero(double value, const std::string& key) {
  if (!(value > 0)) throw UnitError(fmt::format("\"{}\" needs a value above zero behind @", key));
  return value;
}

template <class Band>
void set_band(const std::smatch& part, Budget* budget) {
  if (!part[1].matched) {
    budget->of_surface = Band{};
    return;
  }
  const Band band{frequency_of(part[1].str()), frequency_of(part[2].str())};
  if (!(band.f_min < band.f_max))
    throw UnitError(fmt::format(
        "the upper end of the band of \"{}\" must exceed the lower; expected e.g. rms_height@10/m-100/m",
        budget->key));
  budget->of_surface = band;
}

// A kind of key and the function that applies it.
struct Kind {
  BudgetKey key;
  void (*set)(const std::smatch& part, Budget* budget);
};

std::vector<Kind> light_kinds() {
  const std::string percent = kPercent, plane = kPlane;
  return {
      {{"ee" + percent + "_(radius|diameter)" + plane, "ee80_diameter"},
       [](const std::smatch& part, Budget* budget) {
         budget->statistic = EncircledEnergyRadius{share_of(part[1].str()), plane_of(part[3])};
         budget->is_diameter = part[2] == "diameter";
       }},
      {{"ensquared" + percent + "_side" + plane, "ensquared80_side"},
       [](const std::smatch& part, Budget* budget) {
         budget->of_light = EnsquaredSide{share_of(part[1].str()), plane_of(part[2])};
       }},
      {{"hew", "hew"},
       [](const std::smatch&, Budget* budget) {
         budget->statistic = EncircledEnergyRadius{0.5, 0};
         budget->is_diameter = true;
       }},
      {{"fwhm" + plane, "fwhm"},
       [](const std::smatch& part, Budget* budget) { budget->of_light = IrradianceFwhm{plane_of(part[1])}; }},
      {{"strehl", "strehl"}, [](const std::smatch&, Budget* budget) { budget->of_light = StrehlRatio{}; }},
      {{"tis", "tis"}, [](const std::smatch&, Budget* budget) { budget->of_light = TotalScatter{}; }},
      {{std::string("mtf@") + kFrequencyOfKey, "mtf@20/mm"},
       [](const std::smatch& part, Budget* budget) {
         budget->of_light = ModulationTransfer{frequency_of(part[1].str())};
       }},
      {{std::string("pssn(?:@") + kLengthOfKey + ")?", "pssn@0.15m"},
       [](const std::smatch& part, Budget* budget) {
         PointSourceSensitivity seeing;
         if (part[1].matched) seeing.r0 = above_zero(length_of(part[1].str()), budget->key);
         budget->of_light = seeing;
       }},
      {{std::string("bsdf@") + kAngleOfKey, "bsdf@5deg"}, [](const std::smatch& part, Budget* budget) {
         const double theta = parse_quantity(part[1].str(), Dimension::kAngle);
         if (!(theta < kPi / 2)) throw UnitError(fmt::format("\"{}\" is not below 90 deg", budget->key));
         budget->of_light = PatchBsdf{above_zero(theta, budget->key)};
       }}};
}

std::vector<Kind> surface_kinds() {
  const std::string band = std::string("@") + kFrequencyOfKey + " ?- ?" + kFrequencyOfKey;
  return {{{"rms_height", "rms_height"},
           [](const std::smatch&, Budget* budget) { budget->statistic = RmsHeight{}; }},
          {{"rms_height" + band, "rms_height@10/m-100/m"}, &set_band<HeightInBand>},
          {{"rms_slope(?:" + band + ")?", "rms_slope"}, &set_band<SlopeInBand>},
          {{std::string("structure@") + kLengthOfKey, "structure@10mm"},
           [](const std::smatch& part, Budget* budget) {
             budget->of_surface = HeightDifference{above_zero(length_of(part[1].str()), budget->key)};
           }},
          {{"scatter_rms", "scatter_rms"},
           [](const std::smatch&, Budget* budget) { budget->statistic = ScatterRms{}; }}};
}

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all = [] {
    std::vector<Kind> kinds = light_kinds();
    for (Kind& kind : surface_kinds()) kinds.push_back(std::move(kind));
    return kinds;
  }();
  return all;
}

void set_meaning(Budget* budget) {
  static const std::vector<std::regex> forms = [] {
    std::vector<std::regex> compiled;
    for (const Kind& kind : kinds()) compiled.emplace_back(kind.key.regex);
    return compiled;
  }();
  std::smatch part;
  for (std::size_t k = 0; k < forms.size(); ++k)
    if (std::regex_match(budget->key, part, forms[k])) return kinds()[k].set(part, budget);
  std::string samples;
  for (const Kind& kind : kinds()) samples += (samples.empty() ? "" : ", ") + kind.key.sample;
  throw UnitError(
      fmt::format("\"{}\" is not a budget; expected a key like {}. ee, ensquared and fwhm may name a plane "
                  "(ee80_diameter@1mm), rms_slope a band (rms_slope@10/m-100/m)",
                  budget->key, samples));
}

enum class Bounded { kHeight, kWidth, kAngle, kShare, kSlope, kDifference, kPerSteradian };

Bounded bounded_by(const Budget& budget) {
  if (budget.of_light)
    return std::visit(Overloaded{[](const EnsquaredSide&) { return Bounded::kWidth; },
                                 [](const IrradianceFwhm&) { return Bounded::kWidth; },
                                 [](const PatchBsdf&) { return Bounded::kPerSteradian; },
                                 [](const auto&) { return Bounded::kShare; }},
                      *budget.of_light);
  if (budget.of_surface)
    return std::visit(Overloaded{[](const HeightInBand&) { return Bounded::kHeight; },
                                 [](const SlopeInBand&) { return Bounded::kSlope; },
                                 [](const HeightDifference&) { return Bounded::kDifference; }},
                      *budget.of_surface);
  if (std::holds_alternative<EncircledEnergyRadius>(budget.statistic)) return Bounded::kWidth;
  return std::holds_alternative<RmsHeight>(budget.statistic) ? Bounded::kHeight : Bounded::kAngle;
}

bool is_plain(const std::string& quantity) {
  return quantity.find_first_not_of("0123456789.eE+-") == std::string::npos;
}

void set_limit(const std::string& quantity, Dimension dimension, Budget* budget) {
  budget->dimension = dimension;
  budget->limit = parse_quantity(quantity, dimension);
  budget->unit = std::string(trimmed(quantity.substr(quantity.find_last_of("0123456789.") + 1)));
  budget->unit_size = unit_factor(budget->unit, dimension);
}

// Sets a limit of the first dimension, or an angle if the quantity is not of the first dimension.
void set_limit_or_angle(const std::string& quantity, Dimension first, Budget* budget) {
  try {
    return set_limit(quantity, first, budget);
  } catch (const UnitError&) {
  }
  try {
    set_limit(quantity, Dimension::kAngle, budget);
  } catch (const UnitError& error) {
    throw UnitError(first == Dimension::kNumber
                        ? fmt::format("{}; or a plain number", error.what())
                        : fmt::format("{}; or a length: {}", error.what(), allowed_units(first)));
  }
}

// Accepts "lambda/20" and "0.05 waves".
bool set_wavelengths(const std::string& quantity, Budget* budget) {
  static const std::regex parts(R"((?:lambda|λ|waves?) ?/ ?([0-9.eE+-]+))");
  static const std::regex waves(R"(([0-9.eE+-]+) ?(?:lambda|λ|waves?))");
  std::smatch number;
  const bool inverse = std::regex_match(quantity, number, parts);
  if (!inverse && !std::regex_match(quantity, number, waves)) return false;
  const double value = parse_quantity(number[1].str(), Dimension::kNumber);
  budget->limit = inverse ? 1 / value : value;
  if (!std::isfinite(budget->limit)) throw UnitError(fmt::format("\"{}\" is not finite", quantity));
  budget->dimension = Dimension::kLength;
  budget->in_wavelengths = true;
  budget->unit = "lambda";
  return true;
}

void set_height(const std::string& quantity, Budget* budget) {
  if (set_wavelengths(quantity, budget)) return;
  try {
    set_limit(quantity, Dimension::kLength, budget);
  } catch (const UnitError& error) {
    throw UnitError(fmt::format("{}; or parts of a wavelength as lambda/20", error.what()));
  }
}

// A structure function is an area, its root a length.
void set_difference(const std::string& quantity, Budget* budget) {
  static const std::regex area(R"((.*[a-z])(\^2|²))");
  std::smatch part;
  budget->is_squared = std::regex_match(quantity, part, area);
  if (!budget->is_squared) return set_height(quantity, budget);
  set_limit(part[1].str(), Dimension::kLength, budget);
  budget->limit *= budget->unit_size;
  budget->unit_size *= budget->unit_size;
  budget->unit += "^2";
}

void set_per_steradian(const std::string& quantity, Budget* budget) {
  static const std::regex form(R"(([0-9.eE+-]+)( ?1?/sr| sr\^-1)?)");
  std::smatch part;
  if (!std::regex_match(quantity, part, form))
    throw UnitError(fmt::format(
        "\"{}\" is not a scatter function; expected a number per steradian, \"1e-3 /sr\" or \"1e-3\"",
        quantity));
  budget->dimension = Dimension::kNumber;
  budget->limit = parse_quantity(part[1].str(), Dimension::kNumber);
  budget->unit = part[2].matched ? "/sr" : "";
}

void set_bound(const std::string& typed, Budget* budget) {
  // A height is an RMS value with or without the word.
  static const std::regex root_mean_square(R"((.*\S) (?:RMS|rms))");
  const Bounded what = bounded_by(*budget);
  std::smatch part;
  const bool is_height = what == Bounded::kHeight || what == Bounded::kDifference;
  const std::string quantity =
      is_height && std::regex_match(typed, part, root_mean_square) ? part[1].str() : typed;
  switch (what) {
    case Bounded::kHeight:
      return set_height(quantity, budget);
    case Bounded::kWidth:
      return set_limit_or_angle(quantity, Dimension::kLength, budget);
    case Bounded::kAngle:
      return set_limit(quantity, Dimension::kAngle, budget);
    case Bounded::kShare:  // may be a plain number
      return set_limit(quantity, is_plain(quantity) ? Dimension::kNumber : Dimension::kFraction, budget);
    case Bounded::kSlope:
      return set_limit_or_angle(quantity, Dimension::kNumber, budget);
    case Bounded::kDifference:
      return set_difference(quantity, budget);
    case Bounded::kPerSteradian:
      return set_per_steradian(quantity, budget);
  }
}

bool is_width_of_light(const Budget& budget) { return bounded_by(budget) == Bounded::kWidth; }

}  // namespace

const std::vector<BudgetKey>& budget_keys() {
  static const std::vector<BudgetKey> keys = [] {
    std::vector<BudgetKey> all;
    for (const Kind& kind : kinds()) all.push_back(kind.key);
    return all;
  }();
  return keys;
}

Budget parse_budget(const std::string& key, const std::string& bound) {
  static const std::regex bound_form(R"(\s*(<=|>=)\s*(\S.*?)\s*)");
  Budget budget;
  budget.key = key;
  budget.bound = bound;
  set_meaning(&budget);
  std::smatch part;
  if (!std::regex_match(bound, part, bound_form))
    throw UnitError(fmt::format(
        "\"{}\" is not a bound; expected <= or >= and a quantity, e.g. \"<= 0.6 arcsec\"", bound));
  budget.at_most = part[1] == "<=";
  set_bound(part[2].str(), &budget);
  if (!(budget.limit > 0)) throw UnitError(fmt::format("\"{}\" is not above zero", bound));
  if (bounded_by(budget) == Bounded::kShare && !(budget.limit < 1))
    throw UnitError(fmt::format("\"{}\" is not below 1", bound));
  return budget;
}

Budget at_wavelength(Budget budget, double wavelength) {
  if (!budget.in_wavelengths) return budget;
  budget.limit *= wavelength;
  budget.unit_size = wavelength;
  budget.in_wavelengths = false;
  return budget;
}

double budgeted(const Budget& budget, double value, double focal_length) {
  if (budget.is_squared) return value * value;
  const bool on_sky = budget.dimension == Dimension::kAngle && is_width_of_light(budget);
  return value * (budget.is_diameter ? 2 : 1) / (on_sky ? focal_length : 1);
}

std::string in_budget_unit(const Budget& budget, double value) {
  if (!std::isfinite(value)) return std::isnan(value) ? "none" : "infinite";
  if (budget.unit.empty()) return fmt::format("{:.5g}", value);
  if (budget.unit == "lambda" && value > 0) return fmt::format("lambda/{:.5g}", budget.unit_size / value);
  return fmt::format("{:.5g} {}", value / budget.unit_size, budget.unit);
}

std::string budget_name(const Budget& budget) {
  const std::size_t at = budget.key.find('@');
  const char* unit = "";
  if (budget.is_squared)
    unit = "_m2";
  else if (budget.dimension == Dimension::kAngle)
    unit = "_rad";
  else if (budget.dimension == Dimension::kLength)
    unit = "_m";
  else if (bounded_by(budget) == Bounded::kPerSteradian)
    unit = "_per_sr";
  return budget.key.substr(0, at) + unit + (at == std::string::npos ? "" : budget.key.substr(at));
}

bool is_less_of_smoother(const Budget& budget) {
  if (!budget.of_light) return true;
  return !std::holds_alternative<StrehlRatio>(*budget.of_light) &&
         !std::holds_alternative<ModulationTransfer>(*budget.of_light) &&
         !std::holds_alternative<PointSourceSensitivity>(*budget.of_light);
}

}  // namespace aberfit
