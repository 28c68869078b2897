#include "aperture_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

namespace aberfit::internal {
namespace {

using Point = std::array<double, 2>;

using Box = ApertureBox;

// Area of the intersection of a grid cell and an aperture, and its first moments about the origin.
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

// First moment in x, int_0^b min(a^2, r^2 - y^2)/2 dy, of the disc's part 0 <= x <= a, 0 <= y <= b <= r.
double corner_moment(double r, double a, double b) {
  const double straight = std::sqrt((r - a) * (r + a));
  if (b <= straight) return 0.5 * a * a * b;
  const auto under = [r](double y) { return 0.5 * (r * r - y * y / 3) * y; };
  return 0.5 * a * a * straight + under(b) - under(straight);
}

// Moments of the part of the disc of radius r about the origin with 0 <= x <= a and 0 <= y <= b; a, b >= 0.
AreaMoments disc_corner(double r, double a, double b) {
  a = std::min(a, r);
  b = std::min(b, r);
  if (a * a + b * b <= r * r) return {a * b, 0.5 * a * a * b, 0.5 * a * b * b};
  // A rectangle of height b up to x = sqrt(r^2 - b^2), then the area under the arc up to a.
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
  // These shapes are rasterised instead.
  AreaMoments operator()(const PolygonAperture&) const { return {}; }
  AreaMoments operator()(const SegmentedAperture&) const { return {}; }
};

// Smaller fractions are rounding errors of the areas.
constexpr double kNoCover = 1e-12;

ClearPart clear_part(double share, double x, double y) {
  if (!(share > kNoCover)) return {};
  if (share >= 1 - kNoCover) return {1, 0, 0};
  return {share, x, y};
}

Outline bent(const Outline& corners, double focal_length, double chord) {
  Outline result;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const int chords = std::max(1, int(std::ceil(std::hypot(b[0] - a[0], b[1] - a[1]) / chord)));
    for (int k = 0; k < chords; ++k) {
      const double t = double(k) / chords, x = a[0] + t * (b[0] - a[0]), y = a[1] + t * (b[1] - a[1]);
      const double shrink = 1 / (1 + (x * x + y * y) / (4 * focal_length * focal_length));
      result.push_back({x * shrink, y * shrink});
    }
  }
  return result;
}

}  // namespace

double direction_of(double radius, double focal_length) {
  const double t = radius / (2 * focal_length);
  return radius / (1 + t * t);
}

Aperture in_directions(const Aperture& aperture, double focal_length, double chord) {
  if (!std::isfinite(focal_length)) return aperture;
  if (const auto* circle = std::get_if<CircleAperture>(&aperture))
    return CircleAperture{2 * direction_of(0.5 * circle->diameter, focal_length), 0};
  if (const auto* annulus = std::get_if<AnnulusAperture>(&aperture))
    return AnnulusAperture{2 * direction_of(0.5 * annulus->diameter, focal_length),
                           2 * direction_of(0.5 * annulus->inner_diameter, focal_length), 0};
  SegmentedAperture result;
  for (const Outline& outline : aperture_outlines(aperture))
    result.outlines.push_back(bent(outline, focal_length, chord));
  return result;
}

ApertureCells::ApertureCells(const Aperture& aperture, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y,
                             double pitch_x, double pitch_y)
    : aperture_(aperture), x_(x), y_(y), pitch_x_(pitch_x), pitch_y_(pitch_y) {
  if (const auto* polygon = std::get_if<PolygonAperture>(&aperture)) rasterise({polygon->vertices});
  if (const auto* segmented = std::get_if<SegmentedAperture>(&aperture)) rasterise(segmented->outlines);
}

ClearPart ApertureCells::operator()(Eigen::Index column, Eigen::Index row) const {
  if (!raster_.empty()) {
    const Moments& m = raster_[std::size_t(row * x_.size() + column)];
    return clear_part(m.area, m.x - 0.5 * m.area, m.y - 0.5 * m.area);
  }
  const double x = x_[column], y = y_[row], px = pitch_x_, py = pitch_y_;
  const Box cell{x - 0.5 * px, x + 0.5 * px, y - 0.5 * py, y + 0.5 * py};
  const AreaMoments m = std::visit(CommonPart{cell}, aperture_);
  return clear_part(m.area / (px * py), (m.x - x * m.area) / (px * px * py),
                    (m.y - y * m.area) / (px * py * py));
}

// Green's theorem: the area inside a cell is the sum over the signed edges of the area to their right.
void ApertureCells::rasterise(const std::vector<Outline>& outlines) {
  const Eigen::Index columns = x_.size(), rows = y_.size();
  raster_.assign(std::size_t(columns * rows), {});
  carried_.assign(std::size_t((columns + 1) * rows), {});
  double twice = 0;
  const double left = x_[0] - 0.5 * pitch_x_, low = y_[0] - 0.5 * pitch_y_;
  for (const Outline& outline : outlines)
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Point &a = outline[i], &b = outline[(i + 1) % outline.size()];
      twice += (a[0] - left) * (b[1] - low) - (b[0] - left) * (a[1] - low);
      add_edge((a[0] - left) / pitch_x_, (a[1] - low) / pitch_y_, (b[0] - left) / pitch_x_,
               (b[1] - low) / pitch_y_);
    }
  const double sign = twice > 0 ? -1 : 1;
  for (Eigen::Index row = 0; row < rows; ++row) {
    Moments whole;
    for (Eigen::Index column = 0; column < columns; ++column) {
      whole.add(1, carried_[std::size_t(row * (columns + 1) + column)]);
      Moments& cell = raster_[std::size_t(row * columns + column)];
      cell.add(1, whole);
      cell = {sign * cell.area, sign * cell.x, sign * cell.y};
    }
  }
  carried_.clear();
}

void ApertureCells::add_edge(double u0, double v0, double u1, double v1) {
  const double lowest = std::max(0.0, std::min(v0, v1)),
               highest = std::min(double(y_.size()), std::max(v0, v1));
  const auto at = [&](double v) { return u0 + (v - v0) / (v1 - v0) * (u1 - u0); };
  for (auto row = Eigen::Index(std::floor(lowest)); double(row) < highest; ++row) {
    const double from = std::max(lowest, double(row)), to = std::min(highest, double(row) + 1);
    if (!(to > from)) continue;
    const double u_from = from == v0 ? u0 : from == v1 ? u1 : at(from);
    const double u_to = to == v0 ? u0 : to == v1 ? u1 : at(to);
    if (v1 > v0)
      add_in_row(row, u_from, from, u_to, to);
    else
      add_in_row(row, u_to, to, u_from, from);
  }
}

// Adds a piece of an edge inside one row of grid cells, divided at the column lines.
void ApertureCells::add_in_row(Eigen::Index row, double u0, double v0, double u1, double v1) {
  const Eigen::Index columns = x_.size();
  const auto v_at = [&](double u) { return v0 + (u - u0) / (u1 - u0) * (v1 - v0); };
  double u = u0, v = v0;
  while (true) {
    // The next column line, or the end.
    double next = u1 > u ? std::floor(u) + 1 : std::ceil(u) - 1;
    const bool last = u1 > u ? next >= u1 : next <= u1;
    if (last) next = u1;
    const double v_next = last ? v1 : v_at(next);
    const auto column = Eigen::Index(std::floor(std::min(u, next)));
    const double a0 = u - double(column), a1 = next - double(column), b0 = v - double(row),
                 b1 = v_next - double(row), rise = b1 - b0;
    const Moments right{rise, 0.5 * rise, 0.5 * rise * (b0 + b1)};  // for each cell farther right
    if (column >= 0 && column < columns) {
      const double product = (2 * a0 * b0 + a0 * b1 + a1 * b0 + 2 * a1 * b1) / 6;
      raster_[std::size_t(row * columns + column)].add(
          1, {rise * (1 - 0.5 * (a0 + a1)), 0.5 * rise * (1 - (a0 * a0 + a0 * a1 + a1 * a1) / 3),
              rise * (0.5 * (b0 + b1) - product)});
    }
    const Eigen::Index after = std::clamp<Eigen::Index>(column + 1, 0, columns);
    carried_[std::size_t(row * (columns + 1) + after)].add(1, right);
    if (last) return;
    u = next;
    v = v_next;
  }
}

}  // namespace aberfit::internal
