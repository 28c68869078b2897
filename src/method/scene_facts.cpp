#include "aberfit/method/scene_facts.h"

namespace aberfit {

SceneFacts scene_facts(const Scene& scene, const std::string& theory) {
  SceneFacts facts;
  facts.numbers = scene.numbers;
  facts.theory = theory;
  facts.model = to_string(scene.use.model);
  facts.reason = scene.use.reason;
  if (!scene.use.choice) return facts;
  facts.needed = to_string(scene.use.choice->model);
  facts.errors = scene.use.choice->errors;
  return facts;
}

}  // namespace aberfit
