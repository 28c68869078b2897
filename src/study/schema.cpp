#include "schema.h"

#include <fmt/format.h>

namespace aberfit::internal {
namespace {

using Json = SchemaWriter::Json;

// A number and something after it; which units there are is checked by the reader, because products of powers
// are units, too.
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
  limit(&schema, range);
  return schema;
}

std::string units_note(Dimension dimension) {
  return dimension == Dimension::kNumber ? "" : " Units: " + allowed_units(dimension) + ".";
}

std::string whole(const std::string& regex) { return "^" + regex + "$"; }

}  // namespace

Json SchemaWriter::object_schema(const Body& body, Json* definitions) {
  const auto describe = [&](std::size_t tag_index, std::size_t* tag_count) {
    SchemaWriter inside(definitions);
    inside.tag_index_ = tag_index;
    body(inside);
    *tag_count = inside.tag_count_;
    Json schema;
    schema["type"] = "object";
    schema["properties"] = std::move(inside.properties_);
    if (!inside.required_.empty()) schema["required"] = std::move(inside.required_);
    schema["additionalProperties"] = false;
    return schema;
  };
  std::size_t tags = 0;
  Json schema = describe(0, &tags);
  if (tags == 0) return schema;
  Json alternatives = Json::array({std::move(schema)});
  for (std::size_t i = 1; i < tags; ++i) alternatives.push_back(describe(i, &tags));
  return Json{{"oneOf", std::move(alternatives)}};
}

Json SchemaWriter::named_object(const Body& body, const char* definition) {
  if (!definition) return object_schema(body, definitions_);
  if (!definitions_->contains(definition)) {
    (*definitions_)[definition] = Json::object();  // a description that contains itself finds the name taken
    Json schema = object_schema(body, definitions_);
    (*definitions_)[definition] = std::move(schema);
  }
  return Json{{"$ref", fmt::format("#/$defs/{}", definition)}};
}

void SchemaWriter::add(const Field& field, Json schema) {
  const std::string units = schema.contains("description") ? schema["description"].get<std::string>() : "";
  schema["description"] = field.meaning + (units.empty() ? "" : "." + units);
  if (field.example) schema["examples"] = Json::array({Json::parse(field.example)});
  if (field.need == Need::kRequired) {
    required_.push_back(field.key);
    schema.erase("default");
  }
  properties_[field.key] = std::move(schema);
}

void SchemaWriter::quantity(const Field& field, std::optional<double>& value, Dimension dimension,
                            Range range) {
  Json schema = quantity_schema(dimension, range);
  schema["description"] = units_note(dimension);
  if (value) schema["default"] = *value;
  add(field, std::move(schema));
}

void SchemaWriter::quantities(const Field& field, std::vector<double>& values, Dimension dimension,
                              Range range, bool) {
  Json schema{{"type", "array"}, {"items", quantity_schema(dimension, range)}, {"minItems", 1}};
  schema["description"] = units_note(dimension);
  if (!values.empty()) schema["default"] = values;
  add(field, std::move(schema));
}

// A schema says how the keys look, not how large they may be: that is in the words of the field.
void SchemaWriter::numbered_quantities(const Field& field, std::map<int, double>&, int, int high,
                                       Dimension dimension, Range range) {
  const std::string digits = fmt::format("[1-9][0-9]{{0,{}}}", std::to_string(high).size() - 1);
  Json schema{{"type", "object"},
              {"patternProperties", Json{{whole(digits), quantity_schema(dimension, range)}}},
              {"minProperties", 1},
              {"additionalProperties", false}};
  schema["description"] = units_note(dimension);
  add(field, std::move(schema));
}

void SchemaWriter::word_or_quantity(const Field& field, std::variant<std::string, double>& value,
                                    const std::string& regex, Dimension dimension, Range range) {
  Json schema;
  schema["anyOf"] = {Json{{"type", "string"}, {"pattern", whole(regex)}}, quantity_schema(dimension, range)};
  schema["description"] = units_note(dimension);
  std::visit([&](const auto& held) { schema["default"] = held; }, value);
  add(field, std::move(schema));
}

void SchemaWriter::points(const Field& field, std::vector<std::array<double, 2>>&, std::size_t least) {
  Json pair{{"type", "array"}, {"items", quantity_schema(Dimension::kLength, Range::any())}};
  pair["minItems"] = pair["maxItems"] = 2;
  Json schema{{"type", "array"}, {"items", std::move(pair)}, {"minItems", least}};
  schema["description"] = units_note(Dimension::kLength);
  add(field, std::move(schema));
}

void SchemaWriter::integer(const Field& field, std::optional<std::int64_t>& value, std::int64_t low,
                           std::int64_t high) {
  Json schema{{"type", "integer"}};
  if (low == high)
    schema = Json{{"const", low}};
  else
    schema["minimum"] = low, schema["maximum"] = high;
  if (value) schema["default"] = *value;
  add(field, std::move(schema));
}

void SchemaWriter::seed(const Field& field, std::uint64_t& value) {
  add(field, Json{{"type", "integer"},
                  {"minimum", 0},
                  {"maximum", std::numeric_limits<std::uint64_t>::max()},
                  {"default", value}});
}

void SchemaWriter::boolean(const Field& field, bool& value) {
  add(field, Json{{"type", "boolean"}, {"default", value}});
}

void SchemaWriter::text(const Field& field, std::string& value, bool may_be_empty) {
  Json schema{{"type", "string"}};
  if (!may_be_empty) schema["minLength"] = 1;
  if (!value.empty()) schema["default"] = value;
  add(field, std::move(schema));
}

void SchemaWriter::choice(const Field& field, std::size_t& index, const std::vector<std::string>& names) {
  add(field, Json{{"enum", names}, {"default", names.at(index)}});
}

void SchemaWriter::choices(const Field& field, std::vector<std::size_t>& indices,
                           const std::vector<std::string>& names) {
  Json schema{{"type", "array"}, {"items", Json{{"enum", names}}}, {"uniqueItems", true}};
  if (indices.empty()) schema["default"] = Json::array();
  add(field, std::move(schema));
}

void SchemaWriter::tag(const Field& field, std::size_t& index, const std::vector<std::string>& names) {
  tag_count_ = names.size();
  index = tag_index_;
  add(field, Json{{"const", names.at(index)}});
}

void SchemaWriter::object(const Field& field, bool*, const Body& body, const char* definition) {
  add(field, named_object(body, definition));
}

void SchemaWriter::word_or_object(const Field& field, bool&, const std::string& word, const Body& body) {
  Json schema;
  schema["oneOf"] = {Json{{"const", word}}, object_schema(body, definitions_)};
  schema["default"] = word;
  add(field, std::move(schema));
}

void SchemaWriter::word_or_integer(const Field& field, bool&, const std::string& word, std::int64_t&,
                                   std::int64_t low, std::int64_t high) {
  Json schema;
  schema["oneOf"] = {Json{{"const", word}}, Json{{"type", "integer"}, {"minimum", low}, {"maximum", high}}};
  schema["default"] = word;
  add(field, std::move(schema));
}

void SchemaWriter::list(const Field& field, std::size_t, std::size_t least,
                        const std::function<void(std::size_t)>& resize,
                        const std::function<void(Visitor&, std::size_t)>& body, const char* definition) {
  resize(1);
  Json schema{{"type", "array"}, {"items", named_object([&](Visitor& v) { body(v, 0); }, definition)}};
  if (least > 0) schema["minItems"] = least;
  add(field, std::move(schema));
}

void SchemaWriter::keyed(const Field& field, std::vector<std::string>& keys,
                         const std::vector<KeyPattern>& patterns,
                         const std::function<void(Visitor&, std::size_t)>& body) {
  Json literal = Json::object(), by_pattern = Json::object();
  for (const KeyPattern& pattern : patterns) {
    keys = {pattern.sample};
    Json schema = object_schema([&](Visitor& v) { body(v, 0); }, definitions_);
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

}  // namespace aberfit::internal
