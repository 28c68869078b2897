#pragma once
#include <concepts>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "aberfit/chart/chart.h"
#include "aberfit/chart/check.h"
#include "aberfit/focus/statistic.h"
#include "aberfit/method/frontier.h"
#include "aberfit/method/scene_facts.h"
#include "aberfit/method/tost.h"
#include "aberfit/method/trace_surface.h"
#include "aberfit/method/verify.h"
#include "aberfit/report/psd_report.h"
#include "aberfit/report/result.h"
#include "aberfit/report/sweep_report.h"
#include "aberfit/specify/ceilings.h"
#include "aberfit/specify/psd_of_focus.h"
#include "aberfit/specify/solve.h"
#include "json_number.h"

namespace aberfit::internal {

/// The only description of a result. A function `describe(Facts&, const Part&)` gives each of its numbers
/// once, with key and meaning. It makes both the JSON of a result and the JSON Schema of all results of that
/// kind. A key ends in its SI unit (`rms_height_m`), which the schema repeats as "unit".
///
/// A schema is made from a default-constructed part, so a description must not read anything that only some
/// results have. Optional parts are passed as std::optional, and members of some results with `where`.
class Facts {
 public:
  enum class View { kValues, kSchema };
  explicit Facts(View view) : schema_(view == View::kSchema) {}

  /// A member that every result of this kind has. Numbers that are not finite and empty optionals are null.
  template <typename Value>
  void operator()(const char* key, const Value& value, const char* meaning) {
    where(true, key, value, meaning, true);
  }
  /// A member that is left out if `there` is false.
  template <typename Value>
  void where(bool there, const char* key, const Value& value, const char* meaning, bool always = false) {
    if (schema_)
      put_schema(key, node(value), meaning, always);
    else if (there)
      members_[key] = node(value);
  }
  /// An optional part; if absent it is left out, not null.
  template <typename Value>
  void if_any(const char* key, const std::optional<Value>& value, const char* meaning) {
    where(value.has_value(), key, schema_ || !value ? Value() : *value, meaning);
  }
  /// An object whose members are given by `body`.
  template <typename Body>
  void object(const char* key, const char* meaning, const Body& body) {
    object_where(true, key, meaning, body, true);
  }
  /// The same, but left out if `there` is false.
  template <typename Body>
  void object_where(bool there, const char* key, const char* meaning, const Body& body, bool always = false) {
    if (!schema_ && !there) return;
    Facts inside(view());
    body(inside);
    if (schema_)
      put_schema(key, inside.done(), meaning, always);
    else
      members_[key] = inside.done();
  }
  /// An object whose keys are data: names[k] is the key of items[k].
  template <typename Items>
  void keyed(const char* key, const std::vector<std::string>& names, const Items& items,
             const char* meaning) {
    using Item = std::remove_cvref_t<decltype(*std::begin(items))>;
    if (schema_)
      return put_schema(key, {{"type", "object"}, {"additionalProperties", node(Item())}}, meaning, true);
    Json all = Json::object();
    auto item = std::begin(items);
    for (const std::string& name : names) all[name] = node(*item++);
    members_[key] = std::move(all);
  }
  /// Members whose keys are data and whose values are numbers.
  void numbers(const std::vector<std::pair<std::string, double>>& all, const char* meaning) {
    if (schema_) others_ = {{"type", {"number", "null"}}, {"description", meaning}};
    if (schema_) return;
    for (const auto& [key, value] : all) members_[key] = json_number(value);
  }
  /// A constant word.
  void word(const char* key, const std::string& word, const char* meaning) {
    if (schema_)
      put_schema(key, {{"const", word}}, meaning, true);
    else
      members_[key] = word;
  }

  View view() const { return schema_ ? View::kSchema : View::kValues; }
  /// The JSON of the values, or the schema of the object.
  Json done() {
    if (!schema_) return std::move(members_);
    Json schema = {{"type", "object"}, {"properties", std::move(members_)}};
    if (!required_.empty()) schema["required"] = std::move(required_);
    schema["additionalProperties"] = std::move(others_);
    return schema;
  }

 private:
  template <typename Value>
  Json node(const Value& value) const {
    if constexpr (std::is_same_v<Value, Json>)
      return schema_ ? Json::object() : value;
    else if constexpr (std::is_same_v<Value, bool>)
      return schema_ ? Json{{"type", "boolean"}} : Json(value);
    else if constexpr (std::is_integral_v<Value>)
      return schema_ ? Json{{"type", "integer"}} : Json(value);
    else if constexpr (std::is_floating_point_v<Value>)
      return schema_ ? Json{{"type", {"number", "null"}}} : json_number(value);
    else if constexpr (std::is_convertible_v<Value, std::string>)
      return schema_ ? Json{{"type", "string"}} : Json(std::string(value));
    else if constexpr (std::is_enum_v<Value>)
      return schema_ ? Json{{"type", "string"}} : Json(to_string(value));
    else
      return compound(value);
  }
  template <typename Item>
  Json compound(const std::optional<Item>& value) const {
    if (!schema_) return value ? node(*value) : Json(nullptr);
    Json one = node(Item());
    if (one.contains("type") && one["type"].is_array()) return one;  // null is among its types
    return {{"anyOf", {std::move(one), {{"type", "null"}}}}};
  }
  template <typename Item>
  Json compound(const std::map<std::string, Item>& items) const {
    if (schema_) return {{"type", "object"}, {"additionalProperties", node(Item())}};
    Json all = Json::object();
    for (const auto& [name, item] : items) all[name] = node(item);
    return all;
  }
  template <typename Items>
  requires requires(const Items& items) { std::begin(items); }
  Json compound(const Items& items) const {
    using Item = std::remove_cvref_t<decltype(*std::begin(items))>;
    if (schema_) return {{"type", "array"}, {"items", node(Item())}};
    Json all = Json::array();
    for (const Item& item : items) all.push_back(node(item));
    return all;
  }
  template <typename Part>
  Json compound(const Part& part) const {
    Facts inside(view());
    describe(inside, part);
    return inside.done();
  }
  void put_schema(const char* key, Json schema, const char* meaning, bool always);

  bool schema_;
  Json members_ = Json::object(), required_ = Json::array(), others_ = false;
};

/// The SI unit in the ending of a key: "m", "1/m", "m^4", "rad", "s", "byte"; empty for a pure number or a
/// text.
std::string unit_of_key(const std::string& key);

/// Describes the first members of every document.
void describe_head(Facts& facts, const std::string& kind);

/// Describes a whole document: head, the facts of `part`, and its provenance if `part` does not have it.
template <typename Part>
void describe_document(Facts& facts, const std::string& kind, const Json& study, const std::string& headline,
                       const Part& part, const std::optional<Provenance>& provenance) {
  describe_head(facts, kind);
  facts("study", study, "The study with every default filled in; it is itself a valid study.");
  facts.where(!headline.empty(), "headline", headline, "The answer in a sentence.");
  describe(facts, part);
  facts.if_any("provenance", provenance, "Program, inputs and seed that this result was made with.");
}

/// JSON of `part`, or the schema of its kind of part.
template <typename Part>
Json facts_of(const Part& part) {
  Facts facts(Facts::View::kValues);
  describe(facts, part);
  return facts.done();
}
template <typename Part>
Json schema_of() {
  Facts facts(Facts::View::kSchema);
  describe(facts, Part());
  return facts.done();
}

/// Numbers with the names of their statistics.
struct NamedNumbers {
  std::vector<std::string> names;
  Eigen::VectorXd values;
};

/// RMS height [m] and slope per axis.
struct SplitPart {
  double height = 0, slope = 0;
};
/// The split of a roughness; for a fit also scatter and surface.
struct SplitFacts {
  BandShares shares;
  std::optional<std::vector<AbgFit>> abg;
  std::optional<EquivalentSurface> surface;
};

// These parts occur in many results.
void describe(Facts& facts, const SplitPart& part);
void describe(Facts& facts, const SplitFacts& split);
void describe(Facts& facts, const NamedNumbers& numbers);
void describe(Facts& facts, const Target& target);
void describe(Facts& facts, const EquivalenceMetric& metric);
void describe(Facts& facts, const SceneFacts& scene);
void describe(Facts& facts, const Provenance& provenance);
void describe(Facts& facts, const Warning& warning);
void describe(Facts& facts, const ClearRegion& clear);
/// Empty if the whole measurement is used.
std::optional<ClearRegion> used_part(const ClearRegion& clear);

// These are whole results without the head of their documents.
void describe(Facts& facts, const ResultDocument& result);
void describe(Facts& facts, const CheckReport& report);
void describe(Facts& facts, const MapCheckReport& report);
void describe(Facts& facts, const TraceReport& report);
void describe(Facts& facts, const VerifyReport& report);
void describe(Facts& facts, const Specification& spec);
void describe(Facts& facts, const Ceilings& ceilings);
void describe(Facts& facts, const PsdOfFocus& result);
void describe(Facts& facts, const SweepReport& report);
void describe(Facts& facts, const Chart& chart);
/// A measured PSD with the blocks of the study room.
struct PsdFacts {
  const PsdReport* report = nullptr;
  Json request, roughness;
};
void describe(Facts& facts, const PsdFacts& psd);

}  // namespace aberfit::internal
