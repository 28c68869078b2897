#pragma once
#include <optional>
#include <string>

#include "aberfit/method/groundwork.h"
#include "aberfit/method/outcome.h"

namespace aberfit {

/// Facts of a scene before a surface is fitted: numbers of its specification, and its models.
struct SceneFacts {
  SceneNumbers numbers;
  std::string theory;                 ///< origin of the targets: "geometric", "rays", "ghs", "given"
  std::string model;                  ///< "rays", "waves": how a surface gives statistics
  std::string needed;                 ///< model that the scene needs
  std::string reason;                 ///< why that model is needed, one sentence
  std::optional<ModelErrors> errors;  ///< of rays against GHS
  SpecifiedLight mean_light;          ///< empty: not requested
  MirrorSpread spread;                ///< empty: not requested
};

/// The facts of a scene with roughness and targets by `theory`; `spread` and `mean_light` are left empty.
SceneFacts scene_facts(const Groundwork& ground, const std::string& theory);

}  // namespace aberfit
