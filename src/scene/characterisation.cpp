#include "aberfit/scene/characterisation.h"

#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "aberfit/core/linear_algebra.h"
#include "polygon.h"

namespace aberfit {
namespace {

using Point = std::array<double, 2>;

// Distance from `from` along (cos, sin) to the outermost edge: the first inside point met when walking in,
// then bisection.
std::optional<double> rim_distance(const Aperture& aperture, const Point& from, double cosine, double sine) {
  const auto inside = [&](double d) {
    return aperture_contains(aperture, from[0] + d * cosine, from[1] + d * sine, 0.0);
  };
  const double step = aperture_radius(aperture) / 1024;
  double outside = 2.0 * aperture_radius(aperture) + step, within = outside - step;
  while (within > 0 && !inside(within)) {
    outside = within;
    within -= step;
  }
  if (within <= 0) return std::nullopt;
  for (;;) {
    const double middle = 0.5 * (within + outside);
    if (middle <= within || middle >= outside) return within;
    (inside(middle) ? within : outside) = middle;
  }
}

}  // namespace

MirrorCharacterisation characterise(const Mirror& mirror, const Aperture& aperture, int directions) {
  assert(directions >= 3);
  const auto on_mirror = [&](double x, double y) {
    return Eigen::Vector3d(x, y, base_surface(mirror, x, y).height);
  };
  MirrorCharacterisation result;
  // Every shape but the polygon is centred on the axis.
  const auto* polygon = std::get_if<PolygonAperture>(&aperture);
  const Point centre = polygon ? internal::polygon_area(polygon->vertices).centroid : Point{0, 0};
  result.vertex = on_mirror(0.0, 0.0);
  result.centroid = on_mirror(centre[0], centre[1]);
  result.rim.resize(3, directions);
  Eigen::Index points = 0;
  for (int i = 0; i < directions; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / directions;
    const double cosine = std::cos(angle), sine = std::sin(angle);
    if (const auto distance = rim_distance(aperture, centre, cosine, sine))
      result.rim.col(points++) = on_mirror(centre[0] + *distance * cosine, centre[1] + *distance * sine);
  }
  result.rim.conservativeResize(3, points);

  result.plane_point = result.rim.rowwise().mean();
  const Eigen::Matrix3Xd centred = result.rim.colwise() - result.plane_point;
  // The direction of least variance; distances are taken anew since the smallest singular value loses digits
  // to the largest.
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
