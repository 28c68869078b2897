#pragma once
#include "aberfit/method/scene_facts.h"
#include "aberfit/report/result.h"

namespace aberfit::internal {

/// The same numbers under the same keys as `scene` of a result.
inline Json scene_json(const SceneFacts& facts) {
  ResultDocument result;
  result.has_roughness = true;
  result.scene = facts.numbers;
  result.theory = facts.theory;
  result.model = facts.model;
  result.needed = facts.needed;
  result.model_reason = facts.reason;
  result.errors = facts.errors;
  result.mean_light = facts.mean_light;
  result.spread = facts.spread;
  return scene_json(result);
}

}  // namespace aberfit::internal
