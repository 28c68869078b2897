#include "aberfit/scene/characterisation.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "aberfit/core/linear_algebra.h"
#include "polygon.h"

namespace aberfit {
namespace {

using Point = std::array<double, 2>;

// Distance from `from` along (cos, sin) to the outermost edge; empty when the ray meets no edge.
std::optional<double> rim_distance(const Aperture& aperture, const std::vector<Outline>& outlines,
                                   const Point& from, double cosine, double sine) {
  if (outlines.empty()) return aperture_radius(aperture);
  // Fraction of an edge. A ray through a corner must not pass between two edges.
  constexpr double kCorner = 1e-12;
  std::optional<double> distance;
  for (const Outline& corners : outlines)
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
      const double ex = b[0] - a[0], ey = b[1] - a[1], ax = a[0] - from[0], ay = a[1] - from[1];
      const double across = cosine * ey - sine * ex;
      if (across == 0) continue;  // the edge is parallel to the ray; neighbouring edges cover its ends
      const double along = (ax * ey - ay * ex) / across, part = (ax * sine - ay * cosine) / across;
      if (along > 0 && part >= -kCorner && part <= 1 + kCorner)
        distance = std::max(distance.value_or(0), along);
    }
  return distance;
}

}  // namespace

MirrorCharacterisation characterise(const Mirror& mirror, const Aperture& aperture, int directions) {
  assert(directions >= 3);
  const auto on_mirror = [&](double x, double y) {
    return Eigen::Vector3d(x, y, base_surface(mirror, x, y).height);
  };
  MirrorCharacterisation result;
  const std::vector<Outline> outlines = aperture_outlines(aperture);
  const Point centre = internal::area_of(outlines).centroid;
  result.vertex = on_mirror(0.0, 0.0);
  result.centroid = on_mirror(centre[0], centre[1]);
  result.rim.resize(3, directions);
  Eigen::Index points = 0;
  for (int i = 0; i < directions; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / directions;
    const double cosine = std::cos(angle), sine = std::sin(angle);
    if (const auto distance = rim_distance(aperture, outlines, centre, cosine, sine))
      result.rim.col(points++) = on_mirror(centre[0] + *distance * cosine, centre[1] + *distance * sine);
  }
  result.rim.conservativeResize(3, points);

  result.plane_point = result.rim.rowwise().mean();
  const Eigen::Matrix3Xd centred = result.rim.colwise() - result.plane_point;
  // The normal is the direction of least variance. The smallest singular value loses digits to the largest,
  // so we compute the distances directly.
  result.plane_normal = jacobi_right_vectors(centred.transpose()).col(2);
  if (result.plane_normal.z() < 0) result.plane_normal = -result.plane_normal;
  result.plane_residual =
      std::sqrt((result.plane_normal.transpose() * centred).squaredNorm() / double(points));
  result.rim_sag_min = result.rim.row(2).minCoeff() - result.vertex.z();
  result.rim_sag_max = result.rim.row(2).maxCoeff() - result.vertex.z();
  result.f_number = mirror.focal_length / (2.0 * aperture_radius(aperture));
  return result;
}

}  // namespace aberfit
