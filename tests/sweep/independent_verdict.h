#pragma once
#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>

#include "aberfit/method/groundwork.h"
#include "aberfit/study/study.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// Limits of the cost of a second opinion.
struct OpinionLimits {
  int smallest_grid = 256;  ///< grid points across the aperture
  int largest_grid = 1536;  ///< grid points across the aperture; 16 arrays of its square, 16 bytes each
  double seconds = 600;     ///< as estimated, on one core
  int most_planes = 1000;   ///< in focus and the farthest ones go first
  int most_rings = 3;       ///< the narrowest ones go first; by waves, with as many seconds again
  /// If the largest grid is too small for the field of view, it is used all the same, and the little energy
  /// outside folds back. Planes whose circles do not fit are left out.
  bool narrow_field = false;
  /// Field of view for encircled energies, in largest radii. A rough mirror whose light is all mean scatter
  /// needs four: with three, 1.6e-3 of the energy of an annulus of g 27 was outside (640 points across; below
  /// 5e-4 with 768 to 1536).
  double field = 3;
};

/// Verdict of the tests' own tools on a fitted surface, against the study's targets.
struct SecondOpinion {
  /// Largest |E(r_p) - p| of the judged encircled energies, or difference of ring widths, less the error of
  /// the second opinion itself, in margins of the verdict. NaN: none was formed.
  double worst = std::numeric_limits<double>::quiet_NaN();
  std::string statistic;  ///< whose
  int rings = 0;          ///< number of rings that were judged
  std::string obstacle;   ///< reason why none was formed, a clause
};

/// Second opinions on surfaces for one study. Its targets are computed once.
class SecondOpinions {
 public:
  explicit SecondOpinions(const Study& study);

  /// Second opinion by IndependentWaves, with the roughness above `cut` [cycles/m] by its mean effect. The
  /// field of view of the grid is `field` times the largest radius, and six times for rings, which are wider
  /// out of focus.
  SecondOpinion of_waves(const TermSet& terms, const Eigen::VectorXd& coefficients, std::optional<double> cut,
                         const OpinionLimits& limits) const;
  /// Second opinion by rays of equal parts of the aperture, reflected as vectors. Their error is three
  /// standard errors of eight shifts of a lattice.
  SecondOpinion of_rays(const TermSet& terms, const Eigen::VectorXd& coefficients,
                        const OpinionLimits& limits) const;
  /// Second opinion on the targets themselves, if they are by generalised Harvey-Shack. It uses
  /// IndependentWaves of the mirror without roughness, with all roughness by its mean effect. Not for an
  /// aperture that extends more than 0.35 focal lengths from the axis: on a polygon with g = 8 rings were
  /// wrong by half a margin there.
  SecondOpinion of_targets(const OpinionLimits& limits) const;

 private:
  Study study_;
  Groundwork ground_;
  TargetSets sets_;
};

}  // namespace aberfit
