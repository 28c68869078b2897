#pragma once
#include <optional>
#include <string>

#include "aberfit/method/groundwork.h"
#include "aberfit/method/outcome.h"

namespace aberfit {

/// What is known of a scene before a surface is fitted: numbers of its specification, the models that are
/// used and the one that it needs.
struct SceneFacts {
  SceneNumbers numbers;
  std::string theory;                 ///< "geometric", "rays", "ghs", "given": what targets come from
  std::string model;                  ///< "rays", "waves": what turns a surface into statistics
  std::string needed;                 ///< the same words: what the scene needs
  std::string reason;                 ///< why it is needed, one sentence
  std::optional<ModelErrors> errors;  ///< of rays against GHS
  SpecifiedLight mean_light;          ///< empty: not asked for
  MirrorSpread spread;                ///< empty: not asked for
};

/// The facts of a scene with roughness whose targets come from `theory`; `spread` and `mean_light` are
/// left empty.
SceneFacts scene_facts(const Groundwork& ground, const std::string& theory);

}  // namespace aberfit
