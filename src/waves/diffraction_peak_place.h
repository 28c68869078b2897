#pragma once
#include <Eigen/Core>

#include "diffraction_plane.h"

namespace aberfit::internal {

/// A point of the focal plane, as the phase of one cell of the pupil along x and y [rad]:
/// 2 pi pitch X/(lambda f).
struct FocalPlace {
  double u = 0, v = 0;
};

/// Position of the highest irradiance in the focus, with the transfer function of roughness beyond the
/// heights. The result is exactly the axis if the highest point is within 1e-9 of a sample from it.
FocalPlace highest_place(const DiffractionScene& scene, const DiffractionGrid& grid);

/// Heights [m] at the pupil points that move the point `place` onto the axis: a tilt in direction cosines.
Eigen::ArrayXd tilt_from(const DiffractionScene& scene, const FocalPlace& place);

/// Axial irradiance in the focus over that of the perfect parabola; `plane` must already be focused there.
double axis_ratio(const DiffractionScene& scene, const DiffractionPlane& plane);

}  // namespace aberfit::internal
