#include "aberfit/method/scene_facts.h"

#include "aberfit/method/groundwork.h"

namespace aberfit {

SceneFacts scene_facts(const Groundwork& ground, const std::string& theory) {
  SceneFacts facts;
  facts.numbers = ground.numbers;
  facts.theory = theory;
  facts.model = to_string(ground.use.model);
  facts.reason = ground.use.reason;
  if (!ground.use.choice) return facts;
  facts.needed = to_string(ground.use.choice->model);
  facts.errors = ground.use.choice->errors;
  return facts;
}

}  // namespace aberfit
