#include "aberfit/focus/statistic.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/core/overloaded.h"

namespace aberfit {
namespace {

// At most 6 significant digits, without exponent, trailing zeros or -0, so that each value has one spelling.
std::string digits(double value) {
  const double rounded = std::strtod(fmt::format("{:.5e}", value).c_str(), nullptr);  // for denormals too
  if (rounded == 0.0 || !std::isfinite(rounded)) return fmt::format("{}", std::abs(rounded));
  const int decimals = std::max(0, 5 - int(std::floor(std::log10(std::abs(rounded)))));
  std::string text = fmt::format("{:.{}f}", rounded, decimals);
  if (decimals > 0) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text;
}

std::string encircled(double fraction) { return "ee" + digits(100.0 * fraction); }

std::string plane(double dz) {
  const std::string millimetres = digits(1e3 * dz);
  return millimetres == "0" ? "" : "@" + millimetres + "mm";
}

std::string ring(const RingFwhm& statistic) {
  if (statistic.ring_radius) return "@ring=" + digits(1e6 * *statistic.ring_radius) + "um";
  const std::string name = encircled(statistic.ring_fraction);
  return name == "ee90" ? "" : "@ring=" + name;
}

// One row for each kind, in the order of Statistic.
struct Row {
  StatisticKind kind;
  StudyOption option;
  Statistic (*with)(const StatisticOptions&);
};
template <typename S>
constexpr Row row() {
  Row row{S::kKind, {}, [](const StatisticOptions& options) -> Statistic {
            if constexpr (std::is_empty_v<S>)
              return S{};
            else
              return S::with(options);
          }};
  if constexpr (HasOption<S>) row.option = S::kOption;
  return row;
}
template <typename... S>
std::vector<Row> rows(const std::variant<S...>&) {
  return {row<S>()...};
}
const std::vector<Row> kRows = rows(Statistic{});

const Row& row_of(const std::string& key) {
  const bool percent = key.size() > 2 && key.starts_with("ee") && key[2] >= '0' && key[2] <= '9';
  for (const Row& row : kRows)
    if (row.option.form == StudyOption::kPercent ? percent : key == row.kind.key) return row;
  throw std::invalid_argument("there is no statistic \"" + key + '"');
}

const std::pair<const char*, Dimension> kSuffixes[] = {{"_m", Dimension::kLength},
                                                       {"_rad", Dimension::kAngle}};

// The name before "@..." or "#...", and the remainder.
std::pair<std::string, std::string> stem_of(const std::string& name) {
  const std::size_t stem = std::min(name.find_first_of("@#"), name.size());
  return {name.substr(0, stem), name.substr(stem)};
}

std::string suffix_of(Dimension dimension) {
  for (const auto& [suffix, of] : kSuffixes)
    if (of == dimension) return suffix;
  return "";
}

// stem: the part before the unit, unless it is the key. rest: distinguishes statistics of one kind.
struct NameOf {
  std::string stem, rest;
};
struct Name {
  NameOf operator()(const EncircledEnergyRadius& s) const {
    return {encircled(s.fraction) + "_radius", plane(s.dz)};
  }
  NameOf operator()(const RingFwhm& s) const { return {"", ring(s)}; }
  NameOf operator()(const RingThrough& s) const {
    if (s.is_point) return {"ring_through", plane(s.dz)};
    return {"ee_within_" + digits(1e6 * s.ring_radius) + "um", plane(s.dz)};
  }
  NameOf operator()(const RmsRadius& s) const { return {"", plane(s.dz)}; }
  NameOf operator()(const EnsquaredThrough& s) const {
    return {"ensquared_within_" + digits(1e6 * s.side) + "um", plane(s.dz)};
  }
  NameOf operator()(const ModulationTransfer& s) const {
    return {"", "@" + digits(1e-3 * s.frequency) + "/mm"};
  }
  NameOf operator()(const SpotFwhm&) const { return {}; }
  template <typename Other>
  requires std::is_empty_v<Other> NameOf operator()(const Other&) const { return {}; }
};

}  // namespace

Target aim_of(const Target& target) {
  const auto* radius = std::get_if<EncircledEnergyRadius>(&target.statistic);
  if (!radius || !target.curve_slope) {
    Target aim = target;
    aim.scale = target.relative_to();
    if (!is_share(target.statistic) || target.scale > 0) return aim;
    const bool within = kind_of(target.statistic).measure == Measure::kEnergy;
    aim.scale = within ? kFlattestCurve : std::max(aim.scale, kFlattestCurve);
    return aim;
  }
  const double scale = std::max(*target.curve_slope, kFlattestCurve);
  Target aim;
  aim.statistic = RingThrough{target.value, radius->dz};
  aim.value = radius->fraction;
  aim.standard_error = *target.curve_slope * target.standard_error / target.value;
  aim.tolerance = scale * target.tolerance / target.value;
  aim.scale = scale;
  aim.degrees_of_freedom = target.degrees_of_freedom;
  return aim;
}

std::vector<Target> aims_of(const std::vector<Target>& targets) {
  std::vector<Target> aims(targets.size());
  std::transform(targets.begin(), targets.end(), aims.begin(), aim_of);
  return aims;
}

std::vector<Statistic> statistics_of(const std::vector<Target>& targets) {
  std::vector<Statistic> statistics;
  for (const Target& target : targets) statistics.push_back(target.statistic);
  return statistics;
}

double gaussian_curve_slope(double fraction) { return -2 * (1 - fraction) * std::log1p(-fraction); }

double gaussian_sigma(double radius, double fraction) {
  return radius / std::sqrt(-2 * std::log(1 - fraction));
}

const StatisticKind& kind_of(const Statistic& statistic) { return kRows[statistic.index()].kind; }

bool is_share(const Statistic& statistic) {
  const auto* through = std::get_if<RingThrough>(&statistic);
  return kind_of(statistic).dimension == Dimension::kFraction && !(through && through->is_point);
}

std::optional<double> plane_of_light(const Statistic& statistic) {
  const StatisticKind& kind = kind_of(statistic);
  if (!kind.in_waves() || kind.plane == FocalPlane::kThrough || kind.is_moment()) return std::nullopt;
  return std::visit(Overloaded{[](const HasPlane auto& s) { return s.dz; }, [](const auto&) { return 0.0; }},
                    statistic);
}

const StatisticKind& kind_of_key(const std::string& key) { return row_of(key).kind; }

const StudyOption& option_of_key(const std::string& key) { return row_of(key).option; }

Statistic statistic_of_key(const std::string& key, const StatisticOptions& options) {
  return row_of(key).with(options);
}

std::vector<std::string> request_keys() {
  std::vector<std::string> keys;
  for (const Row& row : kRows)
    if (row.option.form != StudyOption::kPercent) keys.emplace_back(row.kind.key);
  return keys;
}

std::optional<double> spot_sigma(const Statistic& statistic, double value, double focal_length) {
  const double sigma = std::visit(
      Overloaded{
          [&](const EncircledEnergyRadius& s) { return s.dz == 0 ? gaussian_sigma(value, s.fraction) : 0; },
          [&](const RingFwhm& s) { return s.ring_radius.value_or(0) / kGaussianEe90; },
          [&](const RingThrough& s) {
            return s.is_point  ? s.ring_radius / kGaussianEe90
                   : s.dz == 0 ? gaussian_sigma(s.ring_radius, value)
                               : 0;
          },
          [&](const ScatterRms&) { return value * focal_length / std::numbers::sqrt2; },
          [&](const ScatterMean&) { return value * focal_length / std::sqrt(0.5 * kPi); },
          [&](const SpotFwhm&) { return value / std::sqrt(8 * std::numbers::ln2); },
          [&](const RmsRadius&) { return value / std::numbers::sqrt2; }, [](const RmsHeight&) { return 0.0; },
          [](const StrehlRatio&) { return 0.0; }, [](const ModulationTransfer&) { return 0.0; },
          [&](const EnsquaredThrough& s) {
            return s.dz == 0 ? gaussian_sigma(s.side / std::sqrt(kPi), value) : 0;
          }},
      statistic);
  return sigma > 0 && std::isfinite(sigma) ? std::optional(sigma) : std::nullopt;
}

double deciding_radius(const Statistic& statistic, double value) {
  return std::visit(
      Overloaded{[&](const EncircledEnergyRadius& s) { return s.dz == 0 ? value : 0; },
                 [](const RingThrough& s) { return s.ring_radius; },
                 [](const EnsquaredThrough& s) { return s.side / std::numbers::sqrt2; },
                 [](const StrehlRatio&) { return HUGE_VAL; },
                 [](const ModulationTransfer&) { return HUGE_VAL; }, [](const RingFwhm&) { return 0.0; },
                 [](const SpotFwhm&) { return 0.0; }, [](const RayKind auto&) { return 0.0; },
                 [](const MomentKind auto&) { return 0.0; }},
      statistic);
}

Dimension dimension_of_name(const std::string& name) {
  const std::string stem = stem_of(name).first;
  for (const auto& [suffix, dimension] : kSuffixes)
    if (stem.ends_with(suffix)) return dimension;
  return Dimension::kNumber;
}

std::string name_without_unit(const std::string& name) {
  const auto [stem, rest] = stem_of(name);
  return stem.substr(0, stem.size() - suffix_of(dimension_of_name(name)).size()) + rest;
}

std::string statistic_name(const Statistic& statistic) {
  const StatisticKind& kind = kind_of(statistic);
  const NameOf name = std::visit(Name{}, statistic);
  return (name.stem.empty() ? std::string(kind.key) : name.stem) + suffix_of(kind.dimension) + name.rest;
}

}  // namespace aberfit
