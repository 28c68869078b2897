#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "aberfit/report/documents.h"

namespace aberfit::test {

inline bool has_type(const nlohmann::ordered_json& value, const std::string& type) {
  return type == "null"      ? value.is_null()
         : type == "number"  ? value.is_number()
         : type == "integer" ? value.is_number_integer()
         : type == "string"  ? value.is_string()
         : type == "boolean" ? value.is_boolean()
         : type == "array"   ? value.is_array()
                             : value.is_object();
}

/// Checks `value` against `schema`. Returns place and reason of the first fault; empty if there is none. It
/// knows only the part of JSON Schema that the schema of results uses.
inline std::string fault_of(const nlohmann::ordered_json& value, const nlohmann::ordered_json& schema,
                            const std::string& at = "") {
  if (schema.contains("const"))
    return value == schema["const"] ? "" : at + " is not " + schema["const"].dump();
  if (schema.contains("anyOf")) {
    std::string first;
    for (const auto& one : schema["anyOf"]) {
      const std::string fault = fault_of(value, one, at);
      if (fault.empty()) return "";
      if (first.empty()) first = fault;
    }
    return first;
  }
  if (schema.contains("type")) {
    const auto types = schema["type"].is_array() ? schema["type"] : nlohmann::ordered_json{schema["type"]};
    if (std::none_of(types.begin(), types.end(), [&](const auto& type) { return has_type(value, type); }))
      return at + " is no " + types.dump() + ": " + value.dump().substr(0, 60);
  }
  if (value.is_array() && schema.contains("items"))
    for (std::size_t i = 0; i < value.size(); ++i)
      if (std::string fault = fault_of(value[i], schema["items"], at + "/" + std::to_string(i));
          !fault.empty())
        return fault;
  if (!value.is_object()) return "";
  for (const auto& key : schema.value("required", nlohmann::ordered_json::array()))
    if (!value.contains(key)) return at + " lacks " + key.dump();
  const auto members = schema.value("properties", nlohmann::ordered_json::object());
  const auto others = schema.value("additionalProperties", nlohmann::ordered_json(true));
  for (const auto& [key, inner] : value.items()) {
    const std::string place = at + "/" + key;
    if (!members.contains(key) && others == false) return place + " is not in the schema";
    if (!members.contains(key) && others == true) continue;
    if (std::string fault = fault_of(inner, members.contains(key) ? members[key] : others, place);
        !fault.empty())
      return fault;
  }
  return "";
}

/// Expects a result to follow the schema of its kind.
inline void expect_valid_result(const nlohmann::ordered_json& result) {
  static const nlohmann::ordered_json schema = results_schema();
  std::string fault = "no such kind";
  for (const auto& kind : schema["oneOf"])
    if (kind["properties"]["kind"]["const"] == result.value("kind", "")) fault = fault_of(result, kind);
  EXPECT_EQ(fault, "") << "result of kind " << result.value("kind", "");
}

}  // namespace aberfit::test
