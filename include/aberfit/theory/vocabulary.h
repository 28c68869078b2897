#pragma once
#include <string>

namespace aberfit {

/// Theory of the mean spot of a rough mirror; targets without a value come from it.
enum class Theory {
  kGeometric,  ///< Gaussian ray deflections in closed form (GeometricHarveyShack)
  kRays,       ///< the same by Monte Carlo: rays with random deflections (the paper's Harvey-Shack branch)
  kGhs,        ///< generalised Harvey-Shack, wave optics (GeneralisedHarveyShack)
};

/// Law by which a surface slope grad h turns into a ray deflection in the Harvey-Shack branch (PHYSICS 1).
enum class Convention {
  kPhysical,  ///< law of reflection: the ray turns by twice the slope
  kPaper,     ///< D = -grad h added to the unit ray, which is renormalised: half the physical deflection
};

/// Method that computes focal statistics from a surface.
enum class FocusModel {
  kRays,   ///< order statistics and moments of the traced rays
  kWaves,  ///< diffraction of the pupil field, phase 4 pi h/lambda
};

/// The words in studies and results: "geometric", "rays", "ghs"; "rays", "waves".
std::string to_string(Theory theory);
std::string to_string(FocusModel model);

/// The focus model for a surface that is compared with `theory`: waves for kGhs, else rays.
FocusModel model_of(Theory theory);

}  // namespace aberfit
