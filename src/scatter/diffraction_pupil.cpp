#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/scatter/diffraction_psf.h"

namespace aberfit {
namespace {

using Point = std::array<double, 2>;

struct Box {
  double x0, x1, y0, y1;
};

// Area of the part of the disc of radius r about the origin with 0 <= x <= a and 0 <= y <= b; a, b >= 0.
double corner_area(double r, double a, double b) {
  a = std::min(a, r);
  b = std::min(b, r);
  if (a * a + b * b <= r * r) return a * b;
  // Under the arc from x = sqrt(r^2 - b^2) to a; a rectangle of height b before it.
  const double from = std::sqrt((r - b) * (r + b));
  const auto under = [r](double x) {
    return 0.5 * (x * std::sqrt((r - x) * (r + x)) + r * r * std::asin(std::min(x / r, 1.0)));
  };
  return b * from + under(a) - under(from);
}

double disc_area(double r, const Box& c) {
  if (!(r > 0)) return 0;
  const auto nearest = [](double low, double high) { return low > 0 ? low : high < 0 ? -high : 0.0; };
  const auto furthest = [](double low, double high) { return std::max(std::abs(low), std::abs(high)); };
  const double area = (c.x1 - c.x0) * (c.y1 - c.y0);
  if (std::hypot(furthest(c.x0, c.x1), furthest(c.y0, c.y1)) <= r) return area;
  if (std::hypot(nearest(c.x0, c.x1), nearest(c.y0, c.y1)) >= r) return 0;
  const auto signed_corner = [r](double x, double y) {
    return std::copysign(1.0, x) * std::copysign(1.0, y) * corner_area(r, std::abs(x), std::abs(y));
  };
  return signed_corner(c.x1, c.y1) - signed_corner(c.x0, c.y1) - signed_corner(c.x1, c.y0) +
         signed_corner(c.x0, c.y0);
}

// The part of a polygon with sign * coordinate <= sign * limit (Sutherland and Hodgman 1974). Parts that fall
// apart stay joined by edges that cover nothing, so the area is right for bent polygons, too.
std::vector<Point> clipped(const std::vector<Point>& polygon, int axis, double sign, double limit) {
  std::vector<Point> result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = sign * (a[axis] - limit), db = sign * (b[axis] - limit);
    if (da <= 0) result.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
      const double t = da / (da - db);
      result.push_back({a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])});
    }
  }
  return result;
}

double polygon_area(std::vector<Point> polygon, const Box& c) {
  polygon = clipped(polygon, 0, -1, c.x0);
  polygon = clipped(polygon, 0, +1, c.x1);
  polygon = clipped(polygon, 1, -1, c.y0);
  polygon = clipped(polygon, 1, +1, c.y1);
  double twice = 0;  // about a corner of the cell: no cancellation
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += (a[0] - c.x0) * (b[1] - c.y0) - (a[1] - c.y0) * (b[0] - c.x0);
  }
  return 0.5 * std::abs(twice);
}

struct CommonArea {
  const Box& cell;
  double operator()(const CircleAperture& a) const { return disc_area(0.5 * a.diameter, cell); }
  double operator()(const AnnulusAperture& a) const {
    return disc_area(0.5 * a.diameter, cell) - disc_area(0.5 * a.inner_diameter, cell);
  }
  double operator()(const RectangleAperture& a) const {
    const auto overlap = [](double low, double high, double half) {
      return std::max(0.0, std::min(high, half) - std::max(low, -half));
    };
    return overlap(cell.x0, cell.x1, 0.5 * a.width) * overlap(cell.y0, cell.y1, 0.5 * a.height);
  }
  double operator()(const PolygonAperture& a) const { return polygon_area(a.vertices, cell); }
};

struct BoundingBox {
  Box operator()(const CircleAperture& a) const { return square(0.5 * a.diameter); }
  Box operator()(const AnnulusAperture& a) const { return square(0.5 * a.diameter); }
  Box operator()(const RectangleAperture& a) const {
    return {-0.5 * a.width, 0.5 * a.width, -0.5 * a.height, 0.5 * a.height};
  }
  Box operator()(const PolygonAperture& a) const {
    Box box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
    for (const Point& v : a.vertices)
      box = {std::min(box.x0, v[0]), std::max(box.x1, v[0]), std::min(box.y0, v[1]), std::max(box.y1, v[1])};
    return box;
  }
  static Box square(double half) { return {-half, half, -half, half}; }
};

// Shares below this are rounding errors of the areas.
constexpr double kNoCover = 1e-12;

// Builds a pupil cell by cell, row after row.
class PupilBuilder {
 public:
  PupilBuilder(const Aperture& aperture, Eigen::ArrayXd x, Eigen::ArrayXd y, double pitch_x, double pitch_y)
      : aperture_(aperture), grid_{std::move(x), std::move(y), {}, {}} {
    pupil_.pitch_x = pitch_x;
    pupil_.pitch_y = pitch_y;
  }
  double cover(Eigen::Index column, Eigen::Index row) const {
    const double x = grid_.x[column], y = grid_.y[row], a = 0.5 * pupil_.pitch_x, b = 0.5 * pupil_.pitch_y;
    const Box cell{x - a, x + a, y - b, y + b};
    const double share = std::visit(CommonArea{cell}, aperture_) / (pupil_.pitch_x * pupil_.pitch_y);
    return share > kNoCover ? std::min(share, 1.0) : 0.0;
  }
  void add(Eigen::Index column, Eigen::Index row, double cover) {
    grid_.column.push_back(std::uint32_t(column));
    grid_.row.push_back(std::uint32_t(row));
    cover_.push_back(cover);
  }
  DiffractionPupil finish() {
    if (cover_.empty()) throw ComputationError("no cell of the pupil grid lets light through");
    const Eigen::Index n = Eigen::Index(cover_.size());
    pupil_.cover = Eigen::Map<Eigen::ArrayXd>(cover_.data(), n);
    PupilSample& sample = pupil_.sample;
    sample.x.resize(n);
    sample.y.resize(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      sample.x[k] = grid_.x[grid_.column[std::size_t(k)]];
      sample.y[k] = grid_.y[grid_.row[std::size_t(k)]];
    }
    sample.weight = pupil_.cover / pupil_.cover.sum();
    pupil_.amplitude = corrected();
    sample.layout = PupilLayout::kGrid;
    sample.structure = std::move(grid_);
    return std::move(pupil_);
  }
  DiffractionPupil& pupil() { return pupil_; }

 private:
  // Taking the field of a cell from its centre wherever its clear part lies convolves the aperture with a
  // cell, and blurs its edge by pitch^2/24 times the second derivative. Take that off again: (a - b)/24 moves
  // from the smaller to the larger of every two neighbours. Where a neighbour is opaque and has no field to
  // weigh, the same first moment moves between the cell and the one on its other side. Nothing is lost on the
  // way: the total is that of `cover`.
  Eigen::ArrayXd corrected() const {
    const std::ptrdiff_t width = grid_.x.size() + 2;  // an opaque cell all around
    std::vector<double> cover(std::size_t(width * (grid_.y.size() + 2)), 0.0), change = cover;
    std::vector<std::size_t> cell(cover_.size());
    for (std::size_t k = 0; k < cell.size(); ++k) {
      cell[k] = std::size_t((std::ptrdiff_t(grid_.row[k]) + 1) * width + grid_.column[k] + 1);
      cover[cell[k]] = cover_[k];
    }
    for (const std::size_t at : cell) {
      for (const std::ptrdiff_t step : {std::ptrdiff_t(1), std::ptrdiff_t(-1), width, -width}) {
        const std::size_t next = std::size_t(std::ptrdiff_t(at) + step),
                          opposite = std::size_t(std::ptrdiff_t(at) - step);
        if (cover[next] > 0) {
          change[at] += (cover[at] - cover[next]) / 24;
        } else if (cover[opposite] > 0) {
          change[at] -= cover[at] / 24;
          change[opposite] += cover[at] / 24;
        }
      }
    }
    Eigen::ArrayXd result(Eigen::Index(cell.size()));
    for (std::size_t k = 0; k < cell.size(); ++k) result[Eigen::Index(k)] = cover_[k] + change[cell[k]];
    return result;
  }

  const Aperture& aperture_;
  CartesianGrid grid_;
  std::vector<double> cover_;
  DiffractionPupil pupil_;
};

constexpr double kMostCells = 16384;

Eigen::ArrayXd cell_centres(double low, double high, double pitch) {
  // An aperture that is a whole number of cells wide gets just these.
  const double cells = std::max(1.0, std::ceil((high - low) / pitch * (1 - 1e-12) - 1e-9));
  if (!(cells <= kMostCells))
    throw ComputationError("a pupil pitch of " + format_quantity(pitch, Dimension::kLength) +
                           " gives more than " + std::to_string(int(kMostCells)) + " cells a side");
  const double first = 0.5 * (low + high) - 0.5 * (cells - 1) * pitch;
  return first + pitch * Eigen::ArrayXd::LinSpaced(Eigen::Index(cells), 0.0, cells - 1);
}

}  // namespace

DiffractionPupil diffraction_pupil(const Aperture& aperture, double pitch) {
  if (!(pitch > 0)) throw ComputationError("a pupil grid needs a pitch above zero");
  const Box box = std::visit(BoundingBox{}, aperture);
  PupilBuilder builder(aperture, cell_centres(box.x0, box.x1, pitch), cell_centres(box.y0, box.y1, pitch),
                       pitch, pitch);
  const Eigen::Index columns = cell_centres(box.x0, box.x1, pitch).size();
  const Eigen::Index rows = cell_centres(box.y0, box.y1, pitch).size();
  for (Eigen::Index row = 0; row < rows; ++row)
    for (Eigen::Index column = 0; column < columns; ++column)
      if (const double cover = builder.cover(column, row); cover > 0) builder.add(column, row, cover);
  return builder.finish();
}

DiffractionPupil diffraction_pupil(const HeightMap& map, const Aperture& aperture, Eigen::ArrayXd* height) {
  if (!(map.pitch_x > 0) || !(map.pitch_y > 0))
    throw ComputationError("a map needs a pitch before light can be sent through it");
  const auto axis = [](Eigen::Index n, double first, double pitch) -> Eigen::ArrayXd {
    return first + pitch * Eigen::ArrayXd::LinSpaced(n, 0.0, double(n - 1));
  };
  PupilBuilder builder(aperture, axis(map.columns(), map.x0, map.pitch_x),
                       axis(map.rows(), map.y0, map.pitch_y), map.pitch_x, map.pitch_y);
  std::vector<double> values;
  double found = 0;
  for (Eigen::Index row = 0; row < map.rows(); ++row) {
    for (Eigen::Index column = 0; column < map.columns(); ++column) {
      if (!std::isfinite(map.height(row, column))) continue;
      const double cover = builder.cover(column, row);
      if (!(cover > 0)) continue;
      builder.add(column, row, cover);
      values.push_back(map.height(row, column));
      found += cover;
    }
  }
  const double clear = aperture_area(aperture) / (map.pitch_x * map.pitch_y);
  builder.pupil().missing = std::max(0.0, 1.0 - found / clear);
  *height = Eigen::Map<Eigen::ArrayXd>(values.data(), Eigen::Index(values.size()));
  return builder.finish();
}

DiffractionSampling diffraction_sampling(const Aperture& aperture, double focal_length, double wavelength,
                                         double radius, double dz, int least_samples) {
  const double aperture_r = aperture_radius(aperture), distance = focal_length + dz;
  // Light at the distance w/2 from the focus, w = wavelength distance/pitch the field of view, turns the
  // phase by pi from cell to cell; half of that leaves room for what a Gaussian tail or the scatter of a draw
  // adds.
  const double reach = radius + aperture_r * std::abs(dz) / focal_length;
  const double for_reach = 8 * aperture_r * reach / (wavelength * distance);
  DiffractionSampling result;
  result.samples = int(std::ceil(std::max(for_reach, double(least_samples))));
  result.samples += result.samples % 2;
  result.pitch = 2 * aperture_r / result.samples;
  result.reason =
      std::to_string(result.samples) + " cells across the aperture: " +
      (for_reach > least_samples ? "light as far as " + format_quantity(reach, Dimension::kLength) +
                                       " from the focus stays inside half of the field of view"
                                 : std::string("the aperture's edge needs no fewer"));
  return result;
}

}  // namespace aberfit
