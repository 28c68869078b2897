#include "aberfit/focus/statistic.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

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

std::string frequency(double per_metre) { return "@" + digits(1e-3 * per_metre) + "/mm"; }

std::string ring(const RingFwhm& statistic) {
  if (statistic.ring_radius) return "@ring=" + digits(1e6 * *statistic.ring_radius) + "um";
  const std::string name = encircled(statistic.ring_fraction);
  return name == "ee90" ? "" : "@ring=" + name;
}

// The kinds are in the order of Statistic.
const StatisticKind kKinds[] = {
    {"ee", false, Dimension::kLength, true, true, true, false},
    {"ring_fwhm", true, Dimension::kLength, false, true, true, false},
    {"ee_within", true, Dimension::kFraction, true, true, true, false},
    {"scatter_rms", true, Dimension::kAngle, false, true, true, true},
    {"scatter_mean", true, Dimension::kAngle, false, true, true, true},
    {"spot_fwhm", true, Dimension::kLength, false, true, true, false},
    {"rms_radius", true, Dimension::kLength, true, false, true, false},
    {"rms_height", true, Dimension::kLength, false, true, true, true},
    {"strehl", true, Dimension::kFraction, false, true, false, false},
    {"mtf", true, Dimension::kFraction, false, true, false, false},
    {"ensquared_within", true, Dimension::kFraction, true, true, false, false},
};
static_assert(std::size(kKinds) == std::variant_size_v<Statistic>);

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
  NameOf operator()(const ModulationTransfer& s) const { return {"", frequency(s.frequency)}; }
  template <typename Other>
  NameOf operator()(const Other&) const {
    return {};
  }
};

}  // namespace

Target aim_of(const Target& target) {
  const auto* radius = std::get_if<EncircledEnergyRadius>(&target.statistic);
  if (!radius || !target.curve_slope) {
    Target aim = target;
    aim.scale = target.relative_to();
    if (!is_share(target.statistic) || target.scale > 0) return aim;
    const bool within = std::holds_alternative<RingThrough>(target.statistic) ||
                        std::holds_alternative<EnsquaredThrough>(target.statistic);
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
  std::vector<Target> aims;
  aims.reserve(targets.size());
  for (const Target& target : targets) aims.push_back(aim_of(target));
  return aims;
}

std::vector<Statistic> statistics_of(const std::vector<Target>& targets) {
  std::vector<Statistic> statistics;
  statistics.reserve(targets.size());
  for (const Target& target : targets) statistics.push_back(target.statistic);
  return statistics;
}

double gaussian_curve_slope(double fraction) { return -2 * (1 - fraction) * std::log1p(-fraction); }

double gaussian_sigma(double radius, double fraction) {
  return radius / std::sqrt(-2 * std::log(1 - fraction));
}

const StatisticKind& kind_of(const Statistic& statistic) { return kKinds[statistic.index()]; }

bool is_share(const Statistic& statistic) {
  const auto* through = std::get_if<RingThrough>(&statistic);
  return kind_of(statistic).dimension == Dimension::kFraction && !(through && through->is_point);
}

std::optional<double> plane_of_light(const Statistic& statistic) {
  using Plane = std::optional<double>;
  return std::visit(
      Overloaded{
          [](const EncircledEnergyRadius& s) -> Plane { return s.dz; },
          [](const RingThrough& s) -> Plane { return s.dz; },
          [](const EnsquaredThrough& s) -> Plane { return s.dz; },
          [](const SpotFwhm&) -> Plane { return 0.0; }, [](const StrehlRatio&) -> Plane { return 0.0; },
          [](const ModulationTransfer&) -> Plane { return 0.0; }, [](const RingFwhm&) -> Plane { return {}; },
          [](const ScatterRms&) -> Plane { return {}; }, [](const ScatterMean&) -> Plane { return {}; },
          [](const RmsRadius&) -> Plane { return {}; }, [](const RmsHeight&) -> Plane { return {}; }},
      statistic);
}

const StatisticKind& kind_of_key(const std::string& key) {
  for (const StatisticKind& kind : kKinds)
    if (kind.has_key && key == kind.key) return kind;
  const bool percent = key.size() > 2 && key.starts_with("ee") && key[2] >= '0' && key[2] <= '9';
  if (percent) return kind_of(EncircledEnergyRadius{});
  throw std::invalid_argument("there is no statistic \"" + key + '"');
}

std::vector<std::string> request_keys() {
  std::vector<std::string> keys;
  for (const StatisticKind& kind : kKinds)
    if (kind.has_key) keys.push_back(kind.key);
  return keys;
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
  return (name.stem.empty() ? kind.key : name.stem) + suffix_of(kind.dimension) + name.rest;
}

}  // namespace aberfit
