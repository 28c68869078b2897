#pragma once
#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>

#include "aberfit/method/groundwork.h"
#include "aberfit/study/study.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// What may be spent on a second opinion.
struct OpinionLimits {
  int smallest_grid = 256;  ///< cells across the aperture
  int largest_grid = 1536;  ///< cells across the aperture; 16 of them squared are held at 16 bytes each
  double seconds = 600;     ///< as estimated, on one core
  int most_planes = 1000;   ///< in focus and the farthest ones go first
  int most_rings = 3;       ///< the narrowest ones go first; by waves, with as many seconds again
  /// Where the largest grid is too small for the field of view, it is taken all the same: what little light
  /// lies outside comes back in elsewhere. Planes whose circles do not fit are left out.
  bool narrow_field = false;
  /// Field of view of encircled energies, in largest radii. All of a rough mirror's light as the mean of its
  /// scatter wants four: with three, 1.6e-3 of an annulus of g 27 was elsewhere (640 cells; below 5e-4 with
  /// 768 to 1536).
  double field = 3;
};

/// What tools of the tests' own say of a fitted surface, against the study's targets.
struct SecondOpinion {
  /// Largest |E(r_p) - p| of the encircled energies that a verdict is on, and difference of the widths of
  /// rings, less the error of the second opinion itself, in margins of the verdict; NaN: none was formed.
  double worst = std::numeric_limits<double>::quiet_NaN();
  std::string statistic;  ///< whose
  int rings = 0;          ///< that were looked at
  std::string obstacle;   ///< why none was formed, a clause
};

/// Of one study, whose targets are made once.
class SecondOpinions {
 public:
  explicit SecondOpinions(const Study& study);

  /// By IndependentWaves, with the roughness above `cut` [cycles/m] as its mean; a grid whose field of view
  /// holds `field` times the largest radius that is looked at, of rings six times: their light is seen out of
  /// focus.
  SecondOpinion of_waves(const TermSet& terms, const Eigen::VectorXd& coefficients, std::optional<double> cut,
                         const OpinionLimits& limits) const;
  /// By rays of equal parts of the aperture, reflected as vectors; their error is three standard errors of
  /// eight shifts of a lattice.
  SecondOpinion of_rays(const TermSet& terms, const Eigen::VectorXd& coefficients,
                        const OpinionLimits& limits) const;
  /// Of the targets themselves, where they are of generalised Harvey-Shack: by IndependentWaves of the mirror
  /// without roughness, with all of it as its mean. Not where the aperture reaches further from the axis than
  /// 0.35 focal lengths: of a polygon of g 8 that does, rings are half a margin off by them.
  SecondOpinion of_targets(const OpinionLimits& limits) const;

 private:
  Study study_;
  Groundwork ground_;
  TargetSets sets_;
};

}  // namespace aberfit
