#pragma once
#include <string>

namespace aberfit {

/// Study of scene k = 0, 1, ... of a seeded generator: a family of PSDs, g from 0.05 to 20, f/1.5 to f/20, a
/// circle, an annulus, a rectangle or a hexagon of 0.1 to 2 m, bands of 4 to 60 cycles across. Everything
/// else has its default.
struct GeneratedScene {
  std::string name, study;
};
GeneratedScene generated_scene(int k);

}  // namespace aberfit
