#pragma once

namespace aberfit {

/// How a surface slope grad h turns into a ray deflection in the Harvey-Shack branch (PHYSICS 1).
enum class Convention {
  kPhysical,  ///< law of reflection: the ray turns by twice the slope
  kPaper,     ///< D = -grad h added to the unit ray, which is renormalised: half the physical deflection
};

}  // namespace aberfit
