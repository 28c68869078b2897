#pragma once
#include <memory>
#include <vector>

#include "aberfit/scene/aperture.h"

namespace aberfit {

namespace internal {
struct PanelFunction;
}

/// Optical transfer function of a perfect, evenly lit aperture in focus, averaged over direction: of circles
/// and annuli the OTF itself, of all others what encircled energies about the axis depend on. It is a
/// function of the pupil shear x = lambda f nu [m]; real, because OTFs at opposite shears are conjugate; 1 at
/// x = 0.
class ApertureOtf {
 public:
  /// Throws ComputationError for an aperture without opening, and lengths that are not positive.
  explicit ApertureOtf(const Aperture& aperture);

  /// OTF at shear x >= 0 [m]: the overlap of the aperture with its copy, over its area. Circles, annuli
  /// (O'Neill 1956) and rectangles in closed form; all others by their light on cells, within 1e-4 below ten
  /// cells of 1/256 and within 1e-5 beyond.
  double operator()(double x) const;
  /// Shear from which the OTF is 0 [m].
  double cutoff() const { return breakpoints_.back(); }
  /// Shears where it is not smooth, ascending, the last one the cutoff [m].
  const std::vector<double>& breakpoints() const { return breakpoints_; }

 private:
  double outer_ = 0, inner_ = 0;                             // radii [m]
  double width_ = 0, height_ = 0;                            // of a rectangle [m]
  std::shared_ptr<const internal::PanelFunction> by_light_;  // of all others
  std::vector<double> breakpoints_;
};

}  // namespace aberfit
