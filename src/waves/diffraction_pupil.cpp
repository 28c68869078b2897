#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {
namespace {

using Point = std::array<double, 2>;

struct Box {
  double x0, x1, y0, y1;
};

// Area of the common part of a cell and an aperture, and its first moments about the origin.
struct AreaMoments {
  double area = 0, x = 0, y = 0;
};
AreaMoments operator-(const AreaMoments& a, const AreaMoments& b) {
  return {a.area - b.area, a.x - b.x, a.y - b.y};
}

AreaMoments box_moments(const Box& c) {
  const double area = (c.x1 - c.x0) * (c.y1 - c.y0);
  return {area, 0.5 * area * (c.x0 + c.x1), 0.5 * area * (c.y0 + c.y1)};
}

// int_0^b min(a^2, r^2 - y^2)/2 dy: first moment in x of the part of the disc with 0 <= x <= a, 0 <= y <= b
// <= r.
double corner_moment(double r, double a, double b) {
  const double straight = std::sqrt((r - a) * (r + a));
  if (b <= straight) return 0.5 * a * a * b;
  const auto under = [r](double y) { return 0.5 * (r * r - y * y / 3) * y; };
  return 0.5 * a * a * straight + under(b) - under(straight);
}

// The part of the disc of radius r about the origin with 0 <= x <= a and 0 <= y <= b; a, b >= 0.
AreaMoments disc_corner(double r, double a, double b) {
  a = std::min(a, r);
  b = std::min(b, r);
  if (a * a + b * b <= r * r) return {a * b, 0.5 * a * a * b, 0.5 * a * b * b};
  // Under the arc from x = sqrt(r^2 - b^2) to a; a rectangle of height b before it.
  const double from = std::sqrt((r - b) * (r + b));
  const auto under = [r](double x) {
    const double y = std::sqrt((r - x) * (r + x));
    return 0.5 * (x * y + r * r * std::atan2(x, y));  // asin(x/r) would lose half the digits near x = r
  };
  return {b * from + under(a) - under(from), corner_moment(r, a, b), corner_moment(r, b, a)};
}

AreaMoments disc_moments(double r, const Box& c) {
  if (!(r > 0)) return {};
  const auto nearest = [](double low, double high) { return low > 0 ? low : high < 0 ? -high : 0.0; };
  const auto furthest = [](double low, double high) { return std::max(std::abs(low), std::abs(high)); };
  if (std::hypot(furthest(c.x0, c.x1), furthest(c.y0, c.y1)) <= r) return box_moments(c);
  if (std::hypot(nearest(c.x0, c.x1), nearest(c.y0, c.y1)) >= r) return {};
  AreaMoments sum;
  const auto add = [&](double x, double y, double sign) {
    const AreaMoments m = disc_corner(r, std::abs(x), std::abs(y));
    const double sx = std::copysign(1.0, x), sy = std::copysign(1.0, y);
    sum.area += sign * sx * sy * m.area;
    sum.x += sign * sy * m.x;
    sum.y += sign * sx * m.y;
  };
  add(c.x1, c.y1, 1);
  add(c.x0, c.y1, -1);
  add(c.x1, c.y0, -1);
  add(c.x0, c.y0, 1);
  return sum;
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

AreaMoments polygon_moments(std::vector<Point> polygon, const Box& c) {
  polygon = clipped(polygon, 0, -1, c.x0);
  polygon = clipped(polygon, 0, +1, c.x1);
  polygon = clipped(polygon, 1, -1, c.y0);
  polygon = clipped(polygon, 1, +1, c.y1);
  double twice = 0, six_x = 0, six_y = 0;  // about a corner of the cell: no cancellation
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const double ax = polygon[i][0] - c.x0, ay = polygon[i][1] - c.y0;
    const double bx = polygon[(i + 1) % polygon.size()][0] - c.x0,
                 by = polygon[(i + 1) % polygon.size()][1] - c.y0;
    const double cross = ax * by - ay * bx;
    twice += cross;
    six_x += cross * (ax + bx);
    six_y += cross * (ay + by);
  }
  const double sense = twice < 0 ? -1 : 1, area = 0.5 * sense * twice;
  return {area, sense * six_x / 6 + area * c.x0, sense * six_y / 6 + area * c.y0};
}

struct CommonPart {
  const Box& cell;
  AreaMoments operator()(const CircleAperture& a) const { return disc_moments(0.5 * a.diameter, cell); }
  AreaMoments operator()(const AnnulusAperture& a) const {
    return disc_moments(0.5 * a.diameter, cell) - disc_moments(0.5 * a.inner_diameter, cell);
  }
  AreaMoments operator()(const RectangleAperture& a) const {
    const Box common{std::max(cell.x0, -0.5 * a.width), std::min(cell.x1, 0.5 * a.width),
                     std::max(cell.y0, -0.5 * a.height), std::min(cell.y1, 0.5 * a.height)};
    return common.x1 > common.x0 && common.y1 > common.y0 ? box_moments(common) : AreaMoments{};
  }
  AreaMoments operator()(const PolygonAperture& a) const { return polygon_moments(a.vertices, cell); }
};

// Clear share of a cell, and the centre of the clear part from the cell's centre times that share, in
// pitches.
struct Clear {
  double share = 0, x = 0, y = 0;
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
  Clear clear(Eigen::Index column, Eigen::Index row) const {
    const double x = grid_.x[column], y = grid_.y[row], px = pupil_.pitch_x, py = pupil_.pitch_y;
    const Box cell{x - 0.5 * px, x + 0.5 * px, y - 0.5 * py, y + 0.5 * py};
    const AreaMoments m = std::visit(CommonPart{cell}, aperture_);
    const double share = m.area / (px * py);
    if (!(share > kNoCover)) return {};
    if (share >= 1 - kNoCover) return {1, 0, 0};
    return {share, (m.x - x * m.area) / (px * px * py), (m.y - y * m.area) / (px * py * py)};
  }
  void add(Eigen::Index column, Eigen::Index row, const Clear& clear) {
    grid_.column.push_back(std::uint32_t(column));
    grid_.row.push_back(std::uint32_t(row));
    clear_.push_back(clear);
  }
  DiffractionPupil finish() {
    if (clear_.empty()) throw ComputationError("no cell of the pupil grid lets light through");
    const Eigen::Index n = Eigen::Index(clear_.size());
    pupil_.cover.resize(n);
    for (Eigen::Index k = 0; k < n; ++k) pupil_.cover[k] = clear_[std::size_t(k)].share;
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
  // The integral of a smooth field g over the clear part of a cell of unit area is share g + x g_x + y g_y +
  // share (g_xx + g_yy)/24 + third order, g and its derivatives at the centre (inner edges of a cell's clear
  // part change the last term by third order). Derivatives are differences of three clear cells in a line,
  // central where both neighbours are clear. Their weights sum to zero: the total is that of `cover`.
  Eigen::ArrayXd corrected() const {
    const std::ptrdiff_t width = grid_.x.size() + 4;  // two opaque cells all around
    std::vector<char> lit(std::size_t(width * (grid_.y.size() + 4)), 0);
    std::vector<double> weight(lit.size(), 0.0);
    std::vector<std::ptrdiff_t> cell(clear_.size());
    for (std::size_t k = 0; k < cell.size(); ++k) {
      cell[k] = (std::ptrdiff_t(grid_.row[k]) + 2) * width + grid_.column[k] + 2;
      lit[std::size_t(cell[k])] = 1;
      weight[std::size_t(cell[k])] = clear_[k].share;
    }
    const auto spread = [&](std::ptrdiff_t at, std::ptrdiff_t step, double slope, double curvature) {
      const auto is_lit = [&](std::ptrdiff_t n) { return lit[std::size_t(at + n * step)] != 0; };
      const auto give = [&](std::ptrdiff_t n, double w) { weight[std::size_t(at + n * step)] += w; };
      if (is_lit(-1) && is_lit(1)) {
        give(-1, curvature - 0.5 * slope);
        give(0, -2 * curvature);
        give(1, curvature + 0.5 * slope);
        return;
      }
      for (const int side : {-1, 1}) {
        if (!is_lit(side) || !is_lit(2 * side)) continue;
        give(0, curvature - 1.5 * side * slope);
        give(side, -2 * curvature + 2.0 * side * slope);
        give(2 * side, curvature - 0.5 * side * slope);
        return;
      }
    };
    for (std::size_t k = 0; k < cell.size(); ++k) {
      spread(cell[k], 1, clear_[k].x, clear_[k].share / 24);
      spread(cell[k], width, clear_[k].y, clear_[k].share / 24);
    }
    Eigen::ArrayXd result(Eigen::Index(cell.size()));
    for (std::size_t k = 0; k < cell.size(); ++k) result[Eigen::Index(k)] = weight[std::size_t(cell[k])];
    return result;
  }

  const Aperture& aperture_;
  CartesianGrid grid_;
  std::vector<Clear> clear_;
  DiffractionPupil pupil_;
};

Eigen::ArrayXd cell_centres(double low, double high, double pitch) {
  // An aperture that is a whole number of cells wide gets just these.
  const double cells = std::max(1.0, std::ceil((high - low) / pitch * (1 - 1e-12) - 1e-9));
  if (!(cells <= kMostCells))
    throw ComputationError("a pupil pitch of " + format_quantity(pitch, Dimension::kLength) +
                           " gives more than " + std::to_string(kMostCells) + " cells a side");
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
      if (const Clear clear = builder.clear(column, row); clear.share > 0) builder.add(column, row, clear);
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
      const Clear clear = builder.clear(column, row);
      if (!(clear.share > 0)) continue;
      builder.add(column, row, clear);
      values.push_back(map.height(row, column));
      found += clear.share;
    }
  }
  const double cells = aperture_area(aperture) / (map.pitch_x * map.pitch_y);
  builder.pupil().missing = std::max(0.0, 1.0 - found / cells);
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
