#pragma once
#include <memory>
#include <vector>

#include "aberfit/scene/aperture.h"

namespace aberfit {

namespace internal {
struct PanelFunction;
}

/// Optical transfer function of a perfect, evenly illuminated aperture in focus, averaged over direction.
/// Circles and annuli have the OTF itself; for others the average decides the encircled energies about the
/// axis. A function of the pupil shear x = lambda f nu [m], 1 at x = 0; real, as opposite shears are
/// conjugate.
class ApertureOtf {
 public:
  /// Throws ComputationError for an aperture without opening and for lengths that are not positive.
  explicit ApertureOtf(const Aperture& aperture);

  /// OTF at the shear x >= 0 [m]: the overlap of the aperture with its copy, over the aperture's area.
  /// Circles, annuli (O'Neill 1956) and rectangles in closed form. All others from their focal irradiance:
  /// error below 1e-4 at shears under 10/256 of the diameter and 1e-5 beyond.
  double operator()(double x) const;
  /// Shear from which the OTF is 0 [m].
  double cutoff() const { return breakpoints_.back(); }
  /// Shears where the OTF is not smooth, ascending; the last one is the cutoff [m].
  const std::vector<double>& breakpoints() const { return breakpoints_; }

 private:
  double outer_ = 0, inner_ = 0;                             // radii [m]
  double width_ = 0, height_ = 0;                            // of a rectangle [m]
  std::shared_ptr<const internal::PanelFunction> by_light_;  // all other apertures
  std::vector<double> breakpoints_;
};

}  // namespace aberfit
