#pragma once
#include <Eigen/Core>

#include "diffraction_plane.h"

namespace aberfit::internal {

/// A point of the focal plane, as the phase of one cell of the pupil along x and y [rad]:
/// 2 pi pitch X/(lambda f).
struct FocalPlace {
  double u = 0, v = 0;
};

/// Where the irradiance in the focus is highest, for heights that do not stand for all of the roughness with
/// the transfer function of the rest. The axis itself, exactly, where the highest point is not further from
/// it than 1e-9 of a sample.
FocalPlace highest_place(const DiffractionScene& scene, const DiffractionGrid& grid);

/// Heights [m] at the pupil points that move what is at `place` onto the axis: a tilt in direction cosines.
Eigen::ArrayXd tilt_from(const DiffractionScene& scene, const FocalPlace& place);

/// Irradiance on the axis of the focus over that of the perfect parabola; `plane` is there already.
double axis_ratio(const DiffractionScene& scene, const DiffractionPlane& plane);

}  // namespace aberfit::internal
