#pragma once
#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>

#include "aberfit/core/warning.h"
#include "aberfit/measured/clear_aperture.h"

namespace aberfit::internal {

using Json = nlohmann::ordered_json;

/// JSON has no NaN and no infinity: what does not exist is null.
inline Json json_number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

template <typename Array>
Json json_numbers(const Array& values) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < values.size(); ++i) list.push_back(json_number(values[i]));
  return list;
}

/// The head of a file or of what a command prints. study: the resolved study.
inline Json json_document(const std::string& kind, const Json& study) {
  return {{"aberfit", 1}, {"kind", kind}, {"study", study}};
}

/// Null where the whole of a measurement is used.
inline Json clear_json(const ClearRegion& clear) {
  if (!clear.aperture && clear.taken_out == 0 && !clear.said_invalid) return nullptr;
  Json json = {{"aperture", nullptr}, {"centre_m", nullptr}, {"taken_out", clear.taken_out}};
  if (clear.said_invalid) json["said_invalid"] = *clear.said_invalid;
  if (clear.aperture) json["aperture"] = clear.text(), json["centre_m"] = Json::array({clear.x, clear.y});
  return json;
}

inline Json json_warnings(const Warnings& warnings) {
  Json list = Json::array();
  for (const Warning& warning : warnings)
    list.push_back({{"code", warning.code}, {"message", warning.message}});
  return list;
}

}  // namespace aberfit::internal
