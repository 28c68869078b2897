#include "aberfit/scene/quadrature_pupil.h"

#include <array>
#include <cassert>
#include <vector>

#include "aberfit/core/overloaded.h"
#include "aberfit/core/quadrature.h"
#include "polar_rule.h"
#include "polygon.h"

namespace aberfit {
using namespace internal;

namespace {

// The smallest number of equal angles above `degree` for which Fourier transforms are fast.
std::int64_t spokes_above(int degree) {
  std::int64_t spokes = degree + 1;
  while (nearest_smooth(spokes) != spokes) ++spokes;
  return spokes;
}

PupilSample rings_between(double inner, double outer, int degree) {
  return polar_rule(inner, outer, degree / 4 + 1, spokes_above(degree));
}

PupilSample tensor_product(double width, double height, int degree) {
  const int n = degree / 2 + 1;
  const Quadrature along_x = gauss_legendre(n, -width / 2, width / 2),
                   along_y = gauss_legendre(n, -height / 2, height / 2);
  PupilSample pupil;
  pupil.layout = PupilLayout::kGrid;
  for (Eigen::ArrayXd* array : {&pupil.x, &pupil.y, &pupil.weight}) array->resize(Eigen::Index(n) * n);
  CartesianGrid grid{along_x.nodes, along_y.nodes, {}, {}};
  for (int j = 0, k = 0; j < n; ++j)
    for (int i = 0; i < n; ++i, ++k) {
      pupil.x[k] = along_x.nodes[i];
      pupil.y[k] = along_y.nodes[j];
      pupil.weight[k] = along_x.weights[i] * along_y.weights[j] / (width * height);
      grid.column.push_back(std::uint32_t(i));
      grid.row.push_back(std::uint32_t(j));
    }
  pupil.structure = std::move(grid);
  return pupil;
}

Eigen::Index edges_of(const std::vector<Outline>& outlines) {
  std::size_t edges = 0;
  for (const Outline& outline : outlines) edges += outline.size();
  return Eigen::Index(edges);
}

// Signed triangles between the centroid of each outline and its edges.
PupilSample fan(const std::vector<Outline>& outlines, int degree) {
  const double twice_area = area_of(outlines).twice_area;
  // The coordinate u of the square runs from the centroid outwards. Its factor u needs one degree more.
  const Quadrature outwards = gauss_legendre((degree + 1) / 2 + 1, 0, 1),
                   along = gauss_legendre(degree / 2 + 1, 0, 1);
  PupilSample pupil;
  pupil.layout = PupilLayout::kGrid;
  for (Eigen::ArrayXd* array : {&pupil.x, &pupil.y, &pupil.weight})
    array->resize(outwards.nodes.size() * along.nodes.size() * edges_of(outlines));
  Eigen::Index k = 0;
  for (const Outline& vertices : outlines) {
    const auto centre = polygon_area(vertices).centroid;
    for (std::size_t e = 0; e < vertices.size(); ++e) {
      const auto &a = vertices[e], &b = vertices[(e + 1) % vertices.size()];
      const double ax = a[0] - centre[0], ay = a[1] - centre[1], bx = b[0] - centre[0], by = b[1] - centre[1];
      const double share = (ax * by - ay * bx) / twice_area;
      for (Eigen::Index i = 0; i < outwards.nodes.size(); ++i)
        for (Eigen::Index j = 0; j < along.nodes.size(); ++j, ++k) {
          const double u = outwards.nodes[i], v = along.nodes[j];
          pupil.x[k] = centre[0] + u * (ax + v * (bx - ax));
          pupil.y[k] = centre[1] + u * (ay + v * (by - ay));
          pupil.weight[k] = 2 * share * u * outwards.weights[i] * along.weights[j];
        }
    }
  }
  return pupil;
}

}  // namespace

PupilSample quadrature_pupil(const Aperture& aperture, int degree) {
  assert(degree >= 0);
  return std::visit(
      Overloaded{[&](const CircleAperture& a) { return rings_between(0, a.diameter / 2, degree); },
                 [&](const AnnulusAperture& a) {
                   return rings_between(a.inner_diameter / 2, a.diameter / 2, degree);
                 },
                 [&](const RectangleAperture& a) { return tensor_product(a.width, a.height, degree); },
                 [&](const auto&) { return fan(aperture_outlines(aperture), degree); }},
      aperture);
}

double quadrature_points(const Aperture& aperture, int degree) {
  const double along = degree / 2 + 1.0;
  if (std::holds_alternative<RectangleAperture>(aperture)) return along * along;
  if (const Eigen::Index edges = edges_of(aperture_outlines(aperture)); edges > 0)
    return double(edges) * along * along;
  return (degree / 4 + 1.0) * (degree + 1.0);
}

std::optional<Aperture> without_margin(const Aperture& aperture) {
  if (aperture_margin(aperture) == 0) return aperture;
  return std::visit(
      Overloaded{[](const CircleAperture& a) -> std::optional<Aperture> {
                   return CircleAperture{a.diameter - 2 * a.margin, 0};
                 },
                 [](const AnnulusAperture& a) -> std::optional<Aperture> {
                   return AnnulusAperture{a.diameter - 2 * a.margin, a.inner_diameter + 2 * a.margin, 0};
                 },
                 [](const RectangleAperture& a) -> std::optional<Aperture> {
                   return RectangleAperture{a.width - 2 * a.margin, a.height - 2 * a.margin, 0};
                 },
                 [](const auto&) -> std::optional<Aperture> { return std::nullopt; }},
      aperture);
}

}  // namespace aberfit
