#pragma once
#include <string>

namespace aberfit {

/// What says how the light of a rough mirror lies about its focus: where targets without a value come from.
enum class Theory {
  kGeometric,  ///< Gaussian ray deflections in closed form (GeometricHarveyShack)
  kRays,       ///< the same by Monte Carlo: rays with drawn deflections (the paper's Harvey-Shack branch)
  kGhs,        ///< generalised Harvey-Shack, wave optics (GeneralisedHarveyShack)
};

/// How a surface slope grad h turns into a ray deflection in the Harvey-Shack branch (PHYSICS 1).
enum class Convention {
  kPhysical,  ///< law of reflection: the ray turns by twice the slope
  kPaper,     ///< D = -grad h added to the unit ray, which is renormalised: half the physical deflection
};

/// What turns a surface into focal statistics.
enum class FocusModel {
  kRays,   ///< order statistics and moments of the traced rays
  kWaves,  ///< diffraction of the pupil field, phase 4 pi h/lambda
};

/// The words of studies and results: "geometric", "rays", "ghs"; "rays", "waves".
std::string to_string(Theory theory);
std::string to_string(FocusModel model);

/// The model that a surface has to go through to be compared with `theory`: waves for kGhs, else rays.
FocusModel model_of(Theory theory);

}  // namespace aberfit
