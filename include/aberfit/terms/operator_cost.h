#pragma once
#include <Eigen/Core>

#include "aberfit/scene/pupil.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// How many points an operator has and how they are arranged: what its method and its cost depend on beside
/// the terms. Counts that do not apply are zero.
struct PointLayout {
  Eigen::Index points = 0;
  Eigen::Index rings = 0;    ///< polar: rings times spokes are the points
  Eigen::Index spokes = 0;   ///< polar: points per ring
  Eigen::Index rows = 0;     ///< Cartesian grid
  Eigen::Index columns = 0;  ///< Cartesian grid
};
PointLayout point_layout(const PupilSample& pupil);

/// The method of each family of terms: the one that `options` names, else polar for Zernikes on rings and the
/// transform for modes of a lattice, which nothing beats where they can be, and sums at each point otherwise.
/// Predicted seconds are good to a factor of two. Throws std::invalid_argument for a named method that terms
/// or points do not allow.
OperatorChoice choose_operator(const TermSet& terms, const PointLayout& layout,
                               const OperatorOptions& options = {});
OperatorChoice choose_operator(const TermSet& terms, const PupilSample& pupil,
                               const OperatorOptions& options = {});

}  // namespace aberfit
