#pragma once
#include "aberfit/method/scene_facts.h"

namespace aberfit::test {

/// A smooth mirror whose targets and surface are by rays, although waves are needed. The numbers belong to no
/// scene.
inline SceneFacts scene_of_waves() {
  SceneFacts facts;
  facts.numbers.rms_height = 25e-9;
  facts.numbers.rms_slope_per_axis = 1.5e-6;
  facts.numbers.n_eff = 41;
  facts.numbers.g = 0.5;
  facts.numbers.kappa = 0.3;
  facts.numbers.tis = 0.22;
  facts.numbers.paper_ratio_r = 1.84;
  facts.numbers.airy_ee90 = 8.4e-6;
  facts.theory = "geometric";
  facts.model = "rays";
  facts.needed = "waves";
  facts.reason = "kappa is too small.";
  ModelErrors errors;
  errors.ghs = {3e-6, 20e-6, 15e-6};
  errors.rays = {10e-6, 18e-6, 14e-6};
  errors.ray_ee50 = 2.5;
  errors.ray_ee90 = -0.1;
  facts.errors = errors;
  facts.spread.statistics = {{"ee90_radius_m", 0.1, 10}};
  return facts;
}

}  // namespace aberfit::test
