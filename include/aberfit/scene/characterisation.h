#pragma once
#include <Eigen/Core>

#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"

namespace aberfit {

/// The geometry of a mirror before rays are traced (PHYSICS 1). Points are (x, y, z) [m], with z on the
/// mirror without roughness.
struct MirrorCharacterisation {
  Eigen::Vector3d vertex;        ///< intersection of the mirror and its axis
  Eigen::Vector3d centroid;      ///< point of the mirror over the centroid of the aperture's area
  Eigen::Matrix3Xd rim;          ///< outer edge, one point per direction from the centroid
  Eigen::Vector3d plane_point;   ///< mean of the rim points, which lies in the best-fit plane
  Eigen::Vector3d plane_normal;  ///< unit normal of that plane, z component >= 0
  double plane_residual = 0;     ///< standard deviation of the rim's distances from the plane [m]
  double rim_sag_min = 0;        ///< lowest rim point above the vertex [m]
  double rim_sag_max = 0;        ///< highest rim point above the vertex [m]
  double f_number = 0;           ///< focal length / (2 aperture_radius)
};

/// Finds the rim and fits a plane to it. Rim points lie along `directions` >= 3 equally spaced directions
/// from the aperture's centroid; the first direction is +x. Each point is the outermost edge, so the hole of
/// an annulus is ignored. A direction that meets no edge gives no point. The plane comes from a singular
/// value decomposition of the centred points.
MirrorCharacterisation characterise(const Mirror& mirror, const Aperture& aperture, int directions = 360);

}  // namespace aberfit
