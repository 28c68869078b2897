#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "aberfit/core/errors.h"
#include "aberfit/study/parse_json.h"
#include "describe.h"

namespace aberfit {

std::string to_string(CaseLevel level) {
  static const char* const kNames[] = {"check", "trace", "fit", "solve"};
  return kNames[std::size_t(level)];
}

namespace internal {
namespace {

using Json = nlohmann::ordered_json;

// Blocks that do not enter the result of a case cannot vary.
bool can_vary(const std::string& pointer) {
  for (const char* block : {"/vary", "/aberfit", "/output", "/verify", "/title", "/description", "/$schema"})
    if ((pointer + "/").starts_with(std::string(block) + "/")) return false;
  return pointer.size() > 1;
}

void read_list(Visitor& v, const std::string& key, const Json& list, VaryAxis* axis) {
  for (const Json& value : list) {
    axis->values.push_back(value.dump());
    v.check(std::count(axis->values.begin(), axis->values.end(), axis->values.back()) == 1, key,
            value.dump() + " twice", "every value once");
  }
}

void read_range(Visitor& v, const std::string& key, const Json& range, bool grid, VaryAxis* axis) {
  for (const auto& item : range.items())
    v.check(std::set<std::string>{"from", "to", "count", "spacing"}.contains(item.key()),
            child_pointer(key, item.key()), fmt::format("unknown key \"{}\"", item.key()),
            "from, to, count, spacing; or an array of values");
  for (const auto& [name, end] : {std::pair{"from", &axis->from}, {"to", &axis->to}}) {
    const bool there = range.contains(name) && (range[name].is_number() || range[name].is_string());
    v.check(there, child_pointer(key, name), range.contains(name) ? range[name].dump() : kMissing,
            range.contains(name)
                ? "a number, or a text with a unit"
                : fmt::format("a range needs \"{}\", a number or a text with a unit such as \"5 nm\"", name));
    *end = range[name].dump();
  }
  const Json count = range.value("count", Json(nullptr));
  const bool whole = count.is_number_integer() && count >= 2 && count <= kMostOfRange;
  v.check(whole || (!grid && count.is_null()), child_pointer(key, "count"),
          count.is_null() ? kMissing : count.dump(),
          fmt::format("{}an integer from 2 to {}, the number of grid values including both ends",
                      count.is_null() ? "a range needs \"count\", " : "", kMostOfRange));
  axis->count = whole ? count.get<int>() : 0;
  const Json spacing = range.value("spacing", Json("linear"));
  v.check(std::any_of(kSpacings.begin(), kSpacings.end(), [&](const auto& name) { return spacing == name; }),
          child_pointer(key, "spacing"), spacing.dump(), "\"linear\", \"log\", \"integers\"");
  axis->spacing = spacing.get<std::string>();
}

std::string text_of(const VaryAxis& axis) {
  Json json;
  if (!axis.values.empty()) {
    for (const std::string& value : axis.values) json.push_back(Json::parse(value));
    return json.dump();
  }
  json["from"] = Json::parse(axis.from), json["to"] = Json::parse(axis.to);
  if (axis.count > 0) json["count"] = axis.count;
  json["spacing"] = axis.spacing;
  return json.dump();
}

}  // namespace

void describe_vary(Visitor& v, VarySpec& vary) {
  Visitor::TextsByKey over;
  for (const VaryAxis& axis : vary.axes) over.emplace_back(axis.pointer, text_of(axis));
  v.variations({"over",
                "values to vary, by JSON pointer: an array of values as they would stand in the study, or a "
                "range from .. to (for a grid with `count`) with `spacing` linear, log or integers",
                kRequired, R"({"/roughness/psd/rms": {"from": "5 nm", "to": "80 nm", "count": 16}})"},
               over);
  v.choice_of({"design", "grid: all combinations of values; sobol: `cases` points spread evenly"},
              vary.design, {"grid", "sobol"});
  v.integer({"cases", "for sobol: number of points"}, vary.cases, 1, VarySpec::kMostCases);
  v.seed({"seed", "for sobol: seed of the positions"}, vary.seed);
  v.integer(
      {"realisations",
       "number of seeds for each combination, from `fit.seed` on; quantiles are over these realisations"},
      vary.realisations, 1, 1000000);
  v.choice_of(
      {"run",
       "what is computed for each case. check: the prediction of theory; trace: the random surface of the "
       "seed; fit: the whole fit with its verdict, in one thread; solve: the study's `solve` block"},
      vary.run, {"check", "trace", "fit", "solve"});
  if (!v.reading()) return;
  vary.axes.clear();
  for (const auto& [pointer, text] : over) {
    const std::string key = child_pointer("over", pointer);
    v.check(can_vary(pointer), key, '"' + pointer + '"', "a pointer to a value that affects results");
    v.check(pointer != "/fit/seed" || vary.realisations == 1, key, "\"/fit/seed\" beside realisations",
            "only one of the two, because realisations are seeds");
    VaryAxis axis{pointer, {}, {}, {}, 0, "linear"};
    const Json json = Json::parse(text);
    if (json.is_array())
      read_list(v, key, json, &axis);
    else
      read_range(v, key, json, vary.design == VaryDesign::kGrid, &axis);
    vary.axes.push_back(std::move(axis));
  }
  v.check(
      vary.realisations == 1 || vary.run == CaseLevel::kTrace || vary.run == CaseLevel::kFit, "realisations",
      fmt::format("{} with run \"{}\", which has no random surfaces", vary.realisations, to_string(vary.run)),
      "run \"trace\" or \"fit\"; or 1");
}

}  // namespace internal
}  // namespace aberfit
