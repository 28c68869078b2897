#include "aberfit/cases/case_record.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace aberfit {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

std::string to_line(const CaseRecord& record) {
  Json at = Json::object(), values = Json::object();
  for (const auto& [pointer, value] : record.at) at[pointer] = Json::parse(value);
  for (const auto& [name, value] : record.values)
    values[name] = std::isfinite(value) ? Json(value) : Json(nullptr);
  const Json json{{"id", record.id},
                  {"base", record.base},
                  {"index", record.index},
                  {"at", std::move(at)},
                  {"status", record.error.empty() ? "done" : "failed"},
                  {"error", record.error.empty() ? Json(nullptr) : Json(record.error)},
                  {"values", std::move(values)},
                  {"verdict", record.verdict.empty() ? Json(nullptr) : Json(record.verdict)},
                  {"warnings", record.warnings},
                  {"seconds", record.seconds}};
  // A quotation from a file may not be UTF-8.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::optional<CaseRecord> record_of(const std::string& line) {
  try {
    const Json json = Json::parse(line);
    CaseRecord record;
    record.id = json.at("id").get<std::string>();
    record.base = json.at("base").get<std::string>();
    if (!json.at("index").is_number_unsigned()) return std::nullopt;
    record.index = json["index"].get<std::size_t>();
    for (const auto& item : json.at("at").items()) record.at.emplace_back(item.key(), item.value().dump());
    if (json.at("error").is_string()) record.error = json["error"].get<std::string>();
    for (const auto& item : json.at("values").items())
      record.values.emplace_back(item.key(),
                                 item.value().is_null() ? std::nan("") : item.value().get<double>());
    if (json.at("verdict").is_string()) record.verdict = json["verdict"].get<std::string>();
    record.warnings = json.at("warnings").get<std::vector<std::string>>();
    record.seconds = json.at("seconds").get<double>();
    return record;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace aberfit
