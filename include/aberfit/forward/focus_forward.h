#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {

/// What turns a surface into focal statistics.
enum class FocusPhysics {
  kRays,       ///< order statistics and moments of the traced rays
  kConvolved,  ///< the same rays, each spread by the diffraction pattern of the aperture
  kWaves,      ///< diffraction of the pupil field, phase 4 pi h/lambda
};

/// What the statistics of a term surface depend on.
struct FocusScene {
  const Mirror& mirror;
  const PupilSample& pupil;        ///< for kWaves the sample of diffraction_pupil(*aperture, pitch)
  const SurfaceOperator& surface;  ///< L at the pupil points
  FocusPhysics physics = FocusPhysics::kRays;
  double wavelength = 0;               ///< [m]; needed unless kRays
  const Aperture* aperture = nullptr;  ///< needed unless kRays
  Centre centre = Centre::kNominal;    ///< kCentroid: kRays only
};

/// Statistics of the surface with `coefficients` [m], unsmoothed, in the order asked. NaN where one does not
/// exist, each with a warning when `warnings` is given. Throws std::invalid_argument for what the physics
/// cannot do: kCentroid unless kRays, no wavelength or aperture, a pupil that is not a diffraction pupil.
Eigen::VectorXd focus_statistics(const FocusScene& scene, const Eigen::VectorXd& coefficients,
                                 const std::vector<Statistic>& statistics, int threads, Warnings* warnings);

/// The diffraction pattern of the surface with `coefficients` [m] in `window`, as kWaves has it. Throws
/// std::invalid_argument for another physics, and as diffraction_psf does.
PsfImage focus_psf(const FocusScene& scene, const Eigen::VectorXd& coefficients, const PsfWindow& window);

}  // namespace aberfit
