#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "visitor.h"

namespace aberfit::internal {
namespace {

using Json = nlohmann::ordered_json;

// This matches a number and something after it. The reader checks the unit, because products of powers are
// units, too.
const char* const kNumberWithUnit = R"(^\s*-?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*[^\s\d.].*$)";

void limit(Json* schema, Range range) {
  if (std::isfinite(range.low)) (*schema)[range.low_open ? "exclusiveMinimum" : "minimum"] = range.low;
  if (std::isfinite(range.high)) (*schema)[range.high_open ? "exclusiveMaximum" : "maximum"] = range.high;
}

Json quantity_schema(Dimension dimension, Range range) {
  Json schema;
  if (dimension == Dimension::kNumber) {
    schema["type"] = "number";
  } else {
    schema["type"] = {"number", "string"};
    schema["pattern"] = kNumberWithUnit;
  }
  limit(&schema, within_reach(range, dimension));
  return schema;
}

std::string units_note(Dimension dimension) {
  return dimension == Dimension::kNumber ? "" : " Units: " + allowed_units(dimension) + ".";
}

std::string whole(const std::string& regex) { return "^" + regex + "$"; }

Json whole_numbers(const Json& low, const Json& high) {
  return Json{{"type", "integer"}, {"minimum", low}, {"maximum", high}};
}

// Allows the word, which is the default, or what `other` allows.
Json word_or(const std::string& word, Json other) {
  return Json{{"oneOf", {Json{{"const", word}}, std::move(other)}}, {"default", word}};
}

// Documents one object, or one alternative of an object with a tag.
class SchemaWriter : public Visitor {
 public:
  SchemaWriter(Json* definitions, std::size_t tag_index) : definitions_(definitions), tag_index_(tag_index) {}

  std::size_t tag_count() const { return tag_count_; }
  Json schema() const {
    Json result{{"type", "object"}, {"properties", properties_}};
    if (!required_.empty()) result["required"] = required_;
    result["additionalProperties"] = false;
    return result;
  }

  void quantity(const Field& field, std::optional<double>& value, Dimension dimension, Range range) override {
    Json schema = quantity_schema(dimension, range);
    schema["description"] = units_note(dimension);
    if (value) schema["default"] = *value;
    add(field, std::move(schema));
  }
  void quantities(const Field& field, std::vector<double>& values, Dimension dimension, Range range,
                  bool) override {
    Json schema{{"type", "array"}, {"items", quantity_schema(dimension, range)}, {"minItems", 1}};
    schema["description"] = units_note(dimension);
    if (!values.empty()) schema["default"] = values;
    add(field, std::move(schema));
  }
  // A schema can state the form of the keys, but not their largest value, which the field's text gives.
  void numbered_quantities(const Field& field, NumberedQuantities&, int, int high, Dimension dimension,
                           Range range) override {
    const std::string digits = fmt::format("[1-9][0-9]{{0,{}}}", std::to_string(high).size() - 1);
    Json value = quantity_schema(dimension, range);
    value["title"] = "a whole number";
    Json schema{{"type", "object"},
                {"patternProperties", Json{{whole(digits), std::move(value)}}},
                {"minProperties", 1},
                {"additionalProperties", false}};
    schema["description"] = units_note(dimension);
    add(field, std::move(schema));
  }
  void word_or_quantity(const Field& field, WordOrQuantity& value, const std::string& regex,
                        Dimension dimension, Range range) override {
    Json schema;
    schema["anyOf"] = {Json{{"type", "string"}, {"pattern", whole(regex)}},
                       quantity_schema(dimension, range)};
    schema["description"] = units_note(dimension);
    std::visit([&](const auto& held) { schema["default"] = held; }, value);
    add(field, std::move(schema));
  }
  void texts(const Field& field, Names&, std::size_t least, std::size_t most) override {
    add(field, Json{{"type", "array"},
                    {"items", Json{{"type", "string"}, {"minLength", 1}}},
                    {"minItems", least},
                    {"maxItems", most}});
  }
  void texts_by_key(const Field& field, TextsByKey&, const std::vector<KeyPattern>& patterns,
                    const std::string& regex) override {
    Json properties = Json::object();
    for (const KeyPattern& pattern : patterns)
      properties[whole(pattern.regex.empty() ? pattern.literal : pattern.regex)] =
          Json{{"type", "string"}, {"title", pattern.sample}, {"pattern", whole(regex)}};
    add(field, Json{{"type", "object"},
                    {"patternProperties", std::move(properties)},
                    {"minProperties", 1},
                    {"additionalProperties", false}});
  }
  void variations(const Field& field, TextsByKey&) override {
    const Json end{{"type", {"number", "string"}}};
    Json range{{"type", "object"},
               {"properties", Json{{"from", end},
                                   {"to", end},
                                   {"count", whole_numbers(2, kMostOfRange)},
                                   {"spacing", Json{{"enum", kSpacings}}}}},
               {"required", {"from", "to"}},
               {"additionalProperties", false}};
    add(field, Json{{"type", "object"},
                    {"patternProperties",
                     Json{{"^/", Json{{"oneOf", {Json{{"type", "array"}, {"minItems", 1}}, range}}}}}},
                    {"minProperties", 1},
                    {"additionalProperties", false}});
  }
  void points(const Field& field, Points&, std::size_t least) override {
    Json pair{{"type", "array"}, {"items", quantity_schema(Dimension::kLength, Range::any())}};
    pair["minItems"] = pair["maxItems"] = 2;
    Json schema{{"type", "array"}, {"items", std::move(pair)}, {"minItems", least}};
    schema["description"] = units_note(Dimension::kLength);
    add(field, std::move(schema));
  }
  void integer(const Field& field, std::optional<std::int64_t>& value, std::int64_t low,
               std::int64_t high) override {
    Json schema = low == high ? Json{{"const", low}} : whole_numbers(low, high);
    if (value) schema["default"] = *value;
    add(field, std::move(schema));
  }
  void seed(const Field& field, std::uint64_t& value) override {
    Json schema = whole_numbers(0, std::numeric_limits<std::uint64_t>::max());
    schema["default"] = value;
    add(field, std::move(schema));
  }
  void boolean(const Field& field, bool& value) override {
    add(field, Json{{"type", "boolean"}, {"default", value}});
  }
  void text(const Field& field, std::string& value, bool may_be_empty) override {
    Json schema{{"type", "string"}};
    if (!may_be_empty) schema["minLength"] = 1;
    if (!value.empty()) schema["default"] = value;
    add(field, std::move(schema));
  }
  void choice(const Field& field, std::size_t& index, const Names& names) override {
    add(field, Json{{"enum", names}, {"default", names.at(index)}});
  }
  void choices(const Field& field, std::vector<std::size_t>& indices, const Names& names) override {
    Json schema{{"type", "array"}, {"items", Json{{"enum", names}}}, {"uniqueItems", true}};
    if (indices.empty()) schema["default"] = Json::array();
    add(field, std::move(schema));
  }
  void tag(const Field& field, std::size_t& index, const Names& names) override {
    tag_count_ = names.size();
    index = tag_index_;
    add(field, Json{{"const", names.at(index)}});
  }
  void object(const Field& field, bool*, const Body& body, const char* definition) override {
    add(field, named_object(body, definition));
  }
  void word_or_object(const Field& field, bool&, const Names& words, std::size_t& word,
                      const Body& body) override {
    Json allowed = Json::array();
    for (const std::string& one : words) allowed.push_back(Json{{"const", one}});
    allowed.push_back(object_schema(body, definitions_));
    add(field, Json{{"oneOf", std::move(allowed)}, {"default", words.at(word)}});
  }
  void word_or_integer(const Field& field, bool&, const std::string& word, std::int64_t&, std::int64_t low,
                       std::int64_t high) override {
    add(field, word_or(word, whole_numbers(low, high)));
  }
  void list(const Field& field, std::size_t, std::size_t least, const Resize& resize, const ItemBody& body,
            const char* definition) override {
    resize(1);
    Json schema{{"type", "array"}, {"items", named_object([&](Visitor& v) { body(v, 0); }, definition)}};
    if (least > 0) schema["minItems"] = least;
    add(field, std::move(schema));
  }
  void keyed(const Field& field, Names& keys, const std::vector<KeyPattern>& patterns,
             const ItemBody& body) override {
    Json literal = Json::object(), by_pattern = Json::object();
    for (const KeyPattern& pattern : patterns) {
      keys = {pattern.sample};
      Json schema = object_schema([&](Visitor& v) { body(v, 0); }, definitions_);
      schema["title"] = pattern.sample;
      if (pattern.regex.empty())
        literal[pattern.literal] = std::move(schema);
      else
        by_pattern[whole(pattern.regex)] = std::move(schema);
    }
    add(field, Json{{"type", "object"},
                    {"properties", std::move(literal)},
                    {"patternProperties", std::move(by_pattern)},
                    {"additionalProperties", false}});
  }

 private:
  void add(const Field& field, Json schema) {
    const std::string units = schema.contains("description") ? schema["description"].get<std::string>() : "";
    schema["description"] = field.meaning + (units.empty() ? "" : "." + units);
    if (field.example) schema["examples"] = Json::array({Json::parse(field.example)});
    if (field.need == Need::kRequired) {
      required_.push_back(field.key);
      schema.erase("default");
    }
    properties_[field.key] = std::move(schema);
  }
  Json named_object(const Body& body, const char* definition) {
    if (!definition) return object_schema(body, definitions_);
    if (!definitions_->contains(definition)) {
      (*definitions_)[definition] =
          Json::object();  // marks the name, in case the description contains itself
      Json schema = object_schema(body, definitions_);
      (*definitions_)[definition] = std::move(schema);
    }
    return Json{{"$ref", fmt::format("#/$defs/{}", definition)}};
  }

  Json* definitions_;
  std::size_t tag_index_;  // the alternative of a tagged object being described
  Json properties_ = Json::object();
  Json required_ = Json::array();
  std::size_t tag_count_ = 0;  // number of alternatives; 0: not tagged
};

}  // namespace

Json object_schema(const Visitor::Body& body, Json* definitions) {
  Json alternatives = Json::array();
  for (std::size_t i = 0, tags = 1; i < tags; ++i) {
    SchemaWriter inside(definitions, i);
    body(inside);
    tags = inside.tag_count();
    if (tags == 0) return inside.schema();
    alternatives.push_back(inside.schema());
  }
  return Json{{"oneOf", std::move(alternatives)}};
}

}  // namespace aberfit::internal
