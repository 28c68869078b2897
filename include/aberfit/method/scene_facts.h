#pragma once
#include <optional>
#include <string>

#include "aberfit/method/mirror_spread.h"
#include "aberfit/method/specified_light.h"
#include "aberfit/theory/model_choice.h"
#include "aberfit/theory/regime.h"

namespace aberfit {

struct Groundwork;

/// Facts of a scene before a surface is fitted: numbers of its specification, and its models.
struct SceneFacts {
  SceneNumbers numbers;
  std::string theory;                 ///< origin of the targets: "geometric", "rays", "ghs", "given" or "map"
  std::string model = "rays";         ///< "rays", "waves": how a surface gives statistics
  std::string needed;                 ///< model that the scene needs
  std::string reason;                 ///< why that model is needed, one sentence
  std::optional<ModelErrors> errors;  ///< of rays against GHS
  SpecifiedLight mean_light;          ///< empty: not requested
  MirrorSpread spread;                ///< empty: not requested
};

/// The facts of a scene with roughness and targets by `theory`; `spread` and `mean_light` are left empty.
SceneFacts scene_facts(const Groundwork& ground, const std::string& theory);

}  // namespace aberfit
