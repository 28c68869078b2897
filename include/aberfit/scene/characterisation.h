#pragma once
#include <Eigen/Core>

#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"

namespace aberfit {

/// The geometry of a mirror as found before any ray is traced (PHYSICS 1). Points are (x, y, z) with z on the
/// mirror without roughness [m].
struct MirrorCharacterisation {
  Eigen::Vector3d vertex;        ///< where the mirror meets its axis
  Eigen::Vector3d centroid;      ///< point of the mirror over the centroid of the aperture's area
  Eigen::Matrix3Xd rim;          ///< outer edge, one point per direction from the centroid
  Eigen::Vector3d plane_point;   ///< mean of the rim points, which lies in the best-fit plane
  Eigen::Vector3d plane_normal;  ///< unit normal of that plane, z component >= 0
  double plane_residual =
      0;  ///< standard deviation of the rim's distances from the plane [m]: how far from planar the rim is
  double rim_sag_min = 0;  ///< lowest rim point above the vertex [m]
  double rim_sag_max = 0;  ///< highest rim point above the vertex [m]
  double f_number = 0;     ///< focal length / (2 aperture_radius)
};

/// Finds the rim along `directions` equally spaced directions (the first along +x) from the aperture's
/// centroid by bisection of aperture_contains, to rounding, and fits a plane to it by singular value
/// decomposition of the centred points. The rim is the outermost edge: the hole of an annulus is ignored, and
/// a direction that meets no part of the aperture (a centroid outside a bent polygon) gives no point. Strips
/// thinner than 1/1024 of aperture_radius may be missed. directions >= 3.
MirrorCharacterisation characterise(const Mirror& mirror, const Aperture& aperture, int directions = 360);

}  // namespace aberfit
