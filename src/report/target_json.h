#pragma once
#include <nlohmann/json.hpp>

#include "aberfit/focus/statistic.h"
#include "json_number.h"

namespace aberfit::internal {

inline Json target_json(const Target& target) {
  return {{"value", json_number(target.value)},
          {"standard_error", json_number(target.standard_error)},
          {"tolerance", json_number(target.tolerance)}};
}

}  // namespace aberfit::internal
