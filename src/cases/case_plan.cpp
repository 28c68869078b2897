#include "aberfit/cases/case_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/random/sobol.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "aberfit/core/errors.h"
#include "aberfit/core/random.h"
#include "aberfit/core/units.h"

namespace aberfit {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSeed = "/fit/seed";

// Factor from one unit to another of the same dimension.
double factor_between(const std::string& from, const std::string& to) {
  if (from == to) return 1;
  for (const Dimension dimension : {Dimension::kLength, Dimension::kAngle, Dimension::kSpatialFrequency,
                                    Dimension::kFraction, Dimension::kPsd1d, Dimension::kPsd2d}) {
    try {
      return unit_factor(from, dimension) / unit_factor(to, dimension);
    } catch (const UnitError&) {
    }
  }
  throw UnitError(fmt::format("\"{}\" and \"{}\"", to, from));
}

struct RangeEnds {
  double from, to;
  std::string unit;
};

RangeEnds ends_of(const VaryAxis& range) {
  NumberWithUnit from, to;
  for (const auto& [text, end] : {std::pair{&range.from, &from}, {&range.to, &to}})
    if (!read_number(*text, end)) throw UnitError(*text);
  RangeEnds ends{from.number, to.number * factor_between(to.unit, from.unit), from.unit};
  if (range.spacing == "log" && !(ends.from > 0 && ends.to > 0))
    throw std::invalid_argument("a logarithmic range that reaches zero or less");
  if (ends.from == ends.to) throw std::invalid_argument("a range with equal ends");
  return ends;
}

std::string range_text(const RangeEnds& ends, const std::string& spacing, double share) {
  double value = spacing == "log" ? ends.from * std::pow(ends.to / ends.from, share)
                                  : ends.from + share * (ends.to - ends.from);
  if (spacing == "integers") value = std::round(value);
  const std::string digits = fmt::format("{:.12g}", value);
  return ends.unit.empty() ? digits : Json(digits + " " + ends.unit).dump();
}

}  // namespace

bool read_number(const std::string& json, NumberWithUnit* value) {
  const Json parsed = Json::parse(json);
  if (parsed.is_number()) {
    *value = {parsed.get<double>(), ""};
    return true;
  }
  if (!parsed.is_string()) return false;
  const std::string text = parsed.get<std::string>();
  char* end = nullptr;
  value->number = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || !std::isfinite(value->number)) return false;
  while (*end == ' ') ++end;
  value->unit = end;
  while (!value->unit.empty() && value->unit.back() == ' ') value->unit.pop_back();
  return !value->unit.empty();
}

std::string range_value(const VaryAxis& range, double share) {
  return range_text(ends_of(range), range.spacing, share);
}

std::vector<std::vector<double>> shifted_sobol(std::size_t count, std::size_t dimensions,
                                               std::uint64_t seed) {
  boost::random::sobol engine(dimensions);  // leaves out the point 0, whose bits are all zero
  const RandomStream stream(seed, "vary-sobol");
  std::vector<std::vector<double>> points(count, std::vector<double>(dimensions));
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t d = 0; d < dimensions; ++d)
      points[k][d] = 0x1p-53 * double(((k == 0 ? 0 : std::uint64_t(engine())) ^ stream.bits(d)) >> 11);
  return points;
}

CasePlan::CasePlan(const VarySpec& vary, std::uint64_t seed, const std::string& path)
    : realisations_(std::size_t(vary.realisations)), seed_(seed) {
  const bool grid = vary.design == VaryDesign::kGrid;
  double cases = double(realisations_);
  for (const VaryAxis& axis : vary.axes) {
    pointers_.push_back(axis.pointer);
    Axis own{axis.values, axis};
    try {
      if (axis.values.empty()) range_value(axis, 0);
      if (axis.values.empty() && (grid || axis.spacing == "integers") && axis.count > 0)
        for (int k = 0; k < axis.count; ++k) {
          const std::string value = range_value(axis, double(k) / (axis.count - 1));
          if (own.values.empty() || own.values.back() != value)  // equal after rounding
            own.values.push_back(value);
        }
    } catch (const std::exception& error) {
      throw InputError(path, "/vary/over (" + axis.pointer + ")",
                       fmt::format("a range from {} to {}: {}", axis.from, axis.to, error.what()),
                       "two different numbers, both plain or both with units of the same kind; above zero "
                       "for \"log\"");
    }
    cases *= grid ? double(own.values.size()) : 1.0;
    axes_.push_back(std::move(own));
    if (grid) places_ *= axes_.back().values.size();
    if (cases > VarySpec::kMostCases) break;
  }
  if (!grid) cases *= vary.cases;
  if (cases > VarySpec::kMostCases)
    throw InputError(path, "/vary", fmt::format("more than {:.0f} million cases", VarySpec::kMostCases / 1e6),
                     "fewer values, or several sweeps");
  if (!grid) place_sobol(vary);
  if (realisations_ > 1) pointers_.push_back(kSeed);
}

// Points with the same values, as from two lists, are one case.
void CasePlan::place_sobol(const VarySpec& vary) {
  points_ = shifted_sobol(std::size_t(vary.cases), axes_.size(), vary.seed);
  std::set<std::string> seen;
  std::erase_if(points_, [&](const std::vector<double>& point) {
    std::string all;
    for (std::size_t k = 0; k < axes_.size(); ++k) all += sobol_value(k, point[k]) + "\n";
    return !seen.insert(all).second;
  });
  places_ = points_.size();
}

// Integers have equal intervals, including those at the ends.
std::string CasePlan::sobol_value(std::size_t axis, double u) const {
  const Axis& own = axes_[axis];
  if (!own.values.empty()) return own.values[std::size_t(u * double(own.values.size()))];
  if (own.range.spacing != "integers") return range_value(own.range, u);
  const RangeEnds ends = ends_of(own.range);
  const double count = std::abs(std::round(ends.to) - std::round(ends.from));
  const double step = std::floor(u * (count + 1));
  return range_text({std::round(ends.from), std::round(ends.to), ends.unit}, "integers",
                    count > 0 ? step / count : 0);
}

CaseValues CasePlan::at(std::size_t index) const {
  CaseValues values(pointers_.size());
  for (std::size_t k = 0; k < pointers_.size(); ++k) values[k].first = pointers_[k];
  std::size_t place = index / realisations_;
  if (realisations_ > 1) values.back().second = std::to_string(seed_ + index % realisations_);
  for (std::size_t k = axes_.size(); k-- > 0;) {
    if (!points_.empty()) {
      values[k].second = sobol_value(k, points_[place][k]);
      continue;
    }
    const std::size_t count = axes_[k].values.size();
    values[k].second = axes_[k].values[place % count];
    place /= count;
  }
  return values;
}

}  // namespace aberfit
