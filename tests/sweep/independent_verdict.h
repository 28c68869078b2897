#pragma once
#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>

#include "aberfit/study/study.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// What may be spent on a second opinion.
struct OpinionLimits {
  int largest_grid = 1536;  ///< cells across the aperture; 16 of them squared are held at 16 bytes each
  double seconds = 600;     ///< as estimated, on one core
  int most_planes = 1000;   ///< in focus and the farthest ones go first
  int most_rings = 3;       ///< the narrowest ones go first; by waves, with as many seconds again
  /// Where the largest grid is too small for the field of view, it is taken all the same: what little light
  /// lies outside comes back in elsewhere.
  bool narrow_field = false;
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

/// By IndependentWaves, with the roughness above `cut` [cycles/m] as its mean; a grid whose field of view
/// holds three times the largest radius that is looked at, of rings six times: their light is seen out of
/// focus.
SecondOpinion opinion_of_waves(const Study& study, const TermSet& terms, const Eigen::VectorXd& coefficients,
                               std::optional<double> cut, const OpinionLimits& limits);
/// By rays of equal parts of the aperture, reflected as vectors; their error is three standard errors of
/// eight shifts of a lattice.
SecondOpinion opinion_of_rays(const Study& study, const TermSet& terms, const Eigen::VectorXd& coefficients,
                              const OpinionLimits& limits);

}  // namespace aberfit
