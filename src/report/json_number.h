#pragma once
#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>

#include "aberfit/core/warning.h"

namespace aberfit::internal {

/// JSON has no NaN and no infinity: what does not exist is null.
inline nlohmann::ordered_json json_number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

template <typename Array>
nlohmann::ordered_json json_numbers(const Array& values) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (Eigen::Index i = 0; i < values.size(); ++i) list.push_back(json_number(values[i]));
  return list;
}

inline nlohmann::ordered_json json_warnings(const Warnings& warnings) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Warning& warning : warnings)
    list.push_back({{"code", warning.code}, {"message", warning.message}});
  return list;
}

}  // namespace aberfit::internal
