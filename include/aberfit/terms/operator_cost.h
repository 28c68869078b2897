#pragma once
#include <Eigen/Core>

#include "aberfit/scene/pupil.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// Number and arrangement of an operator's points; its method and cost depend on them. Others are zero.
struct PointLayout {
  Eigen::Index points = 0;
  Eigen::Index rings = 0;    ///< polar: points = rings times spokes
  Eigen::Index spokes = 0;   ///< polar: points per ring
  Eigen::Index rows = 0;     ///< Cartesian grid
  Eigen::Index columns = 0;  ///< Cartesian grid
};
PointLayout point_layout(const PupilSample& pupil);

/// Chooses the method of each family of terms: the one in `options`; else the polar one for Zernike terms on
/// rings and the transform for lattice modes, which are always fastest; else sums at each point. Predicted
/// times are correct to a factor of two. Throws std::invalid_argument for a method that is not possible.
OperatorChoice choose_operator(const TermSet& terms, const PointLayout& layout,
                               const OperatorOptions& options = {});
OperatorChoice choose_operator(const TermSet& terms, const PupilSample& pupil,
                               const OperatorOptions& options = {});

}  // namespace aberfit
