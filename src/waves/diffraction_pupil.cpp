#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/scene/segments.h"
#include "aberfit/waves/diffraction_psf.h"
#include "aperture_cells.h"

namespace aberfit {
using namespace internal;

namespace {

// Straight edges of the mirror are curved in P. Chords of a quarter of a cell leave an area of pitch^2/(8
// 16^2 f) along each, far below the error of the grid.
constexpr double kChord = 0.25;

// Rays from farther out than this many focal lengths meet the axis at more than 87 degrees.
constexpr double kDeepest = 1.9;

// Rays of deeper mirrors hardly reach planes out of focus.
constexpr double kLeastCosine = 0.05;

// Origin of the ray P = f sin(theta): r = P (1 + t^2), t = r/2f = tan(theta/2), and the area ratio d2r/d2P.
struct DirectedPoint {
  double stretch = 1;   // r/P = 1 + t^2
  double jacobian = 1;  // (1 + t^2)^3/(1 - t^2)
};
DirectedPoint directed_point(double direction, double focal_length) {
  if (!std::isfinite(focal_length)) return {};
  const double sine = std::min(direction / focal_length, 1 - 1e-6);  // centres of edge cells may lie outside
  const double cosine = std::sqrt((1 - sine) * (1 + sine)), stretch = 2 / (1 + cosine);
  return {stretch, stretch * stretch / cosine};
}

// Builds a pupil cell by cell, either row after row or segment after segment.
class PupilBuilder {
 public:
  PupilBuilder(Eigen::ArrayXd x, Eigen::ArrayXd y, double pitch_x, double pitch_y)
      : grid_{std::move(x), std::move(y), {}, {}} {
    pupil_.pitch_x = pitch_x;
    pupil_.pitch_y = pitch_y;
  }
  void add(Eigen::Index column, Eigen::Index row, const ClearPart& clear) {
    grid_.column.push_back(std::uint32_t(column));
    grid_.row.push_back(std::uint32_t(row));
    clear_.push_back(clear);
  }
  /// Adds the grid cells that a shape leaves clear.
  void add_all(const Aperture& shape) {
    const auto span = [](const Eigen::ArrayXd& centres, double pitch, double low, double high) {
      const auto last = double(centres.size() - 1);
      const double first = std::floor((low - centres[0]) / pitch),
                   end = std::ceil((high - centres[0]) / pitch);
      return std::array<Eigen::Index, 2>{Eigen::Index(std::clamp(first, 0.0, last)),
                                         Eigen::Index(std::clamp(end, 0.0, last))};
    };
    const ApertureBox box = bounding_box(shape);
    const auto columns = span(grid_.x, pupil_.pitch_x, box.x0, box.x1),
               rows = span(grid_.y, pupil_.pitch_y, box.y0, box.y1);
    const Eigen::ArrayXd x = grid_.x.segment(columns[0], columns[1] - columns[0] + 1),
                         y = grid_.y.segment(rows[0], rows[1] - rows[0] + 1);
    const ApertureCells cells(shape, x, y, pupil_.pitch_x, pupil_.pitch_y);
    for (Eigen::Index row = 0; row < y.size(); ++row)
      for (Eigen::Index column = 0; column < x.size(); ++column)
        if (const ClearPart clear = cells(column, row); clear.share > 0)
          add(columns[0] + column, rows[0] + row, clear);
  }
  /// Adds one of several segments, with cells of its own.
  void add_segment(const Aperture& shape) {
    segments_.push_back(clear_.size());
    add_all(shape);
  }
  const CartesianGrid& grid() const { return grid_; }
  /// Adds points on the mirror if the grid is one of direction cosines (finite focal length).
  DiffractionPupil finish(double focal_length, std::array<double, 2> shift) {
    if (clear_.empty()) throw ComputationError("no pixel of the pupil grid lets light through");
    const Eigen::Index n = Eigen::Index(clear_.size());
    pupil_.cover.resize(n);
    if (segments_.empty()) pupil_.amplitude = corrected(0, clear_.size());
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      const std::size_t end = s + 1 < segments_.size() ? segments_[s + 1] : clear_.size();
      pupil_.amplitude.conservativeResize(Eigen::Index(end));
      pupil_.amplitude.tail(Eigen::Index(end - segments_[s])) = corrected(segments_[s], end);
      pupil_.sample.segment.resize(end, std::uint32_t(s));
    }
    pupil_.obliquity.resize(n);
    PupilSample& sample = pupil_.sample;
    sample.x.resize(n);
    sample.y.resize(n);
    sample.weight.resize(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const double x = grid_.x[grid_.column[std::size_t(k)]], y = grid_.y[grid_.row[std::size_t(k)]];
      const DirectedPoint point = directed_point(std::hypot(x, y), focal_length);
      pupil_.cover[k] = clear_[std::size_t(k)].share;
      sample.x[k] = x * point.stretch;
      sample.y[k] = y * point.stretch;
      sample.weight[k] = pupil_.cover[k] * point.jacobian;
      pupil_.amplitude[k] *= std::sqrt(point.jacobian);
      pupil_.obliquity[k] = 1 / point.stretch;
    }
    sample.weight /= sample.weight.sum();
    sample.layout = PupilLayout::kGrid;
    if (std::isfinite(focal_length))
      sample.structure = DirectionGrid{std::move(grid_), focal_length, shift};
    else
      sample.structure = std::move(grid_);
    return std::move(pupil_);
  }
  DiffractionPupil& pupil() { return pupil_; }

 private:
  // The integral of a smooth field g over the clear part of a cell of unit area is share g + x g_x + y g_y +
  // share (g_xx + g_yy)/24 + third order, with g and its derivatives at the centre. Derivatives are
  // differences of three clear cells in a line, central if both neighbours are clear. Their weights sum to
  // zero, so the total is that of `cover`.
  Eigen::ArrayXd corrected(std::size_t begin, std::size_t end) const {
    const auto range = [&](const std::vector<std::uint32_t>& of) {
      const auto [low, high] =
          std::minmax_element(of.begin() + std::ptrdiff_t(begin), of.begin() + std::ptrdiff_t(end));
      return begin == end ? std::array<std::ptrdiff_t, 2>{}
                          : std::array<std::ptrdiff_t, 2>{*low, *high - *low + 1};
    };
    const auto columns = range(grid_.column), rows = range(grid_.row);
    const std::ptrdiff_t width = columns[1] + 4;  // includes two opaque cells on each side
    std::vector<char> lit(std::size_t(width * (rows[1] + 4)), 0);
    std::vector<double> weight(lit.size(), 0.0);
    std::vector<std::ptrdiff_t> cell(end - begin);
    for (std::size_t k = 0; k < cell.size(); ++k) {
      cell[k] = (grid_.row[begin + k] - rows[0] + 2) * width + grid_.column[begin + k] - columns[0] + 2;
      lit[std::size_t(cell[k])] = 1;
      weight[std::size_t(cell[k])] = clear_[begin + k].share;
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
      const ClearPart& clear = clear_[begin + k];
      spread(cell[k], 1, clear.x, clear.share / 24);
      spread(cell[k], width, clear.y, clear.share / 24);
    }
    Eigen::ArrayXd result(Eigen::Index(cell.size()));
    for (std::size_t k = 0; k < cell.size(); ++k) result[Eigen::Index(k)] = weight[std::size_t(cell[k])];
    return result;
  }

  CartesianGrid grid_;
  std::vector<ClearPart> clear_;
  std::vector<std::size_t> segments_;  // start of each segment
  DiffractionPupil pupil_;
};

Eigen::ArrayXd cell_centres(double low, double high, double pitch, double shift) {
  // An aperture of a whole number of cells gets exactly that number; a shift needs one more.
  const double cells =
      std::max(1.0, std::ceil((high - low) / pitch * (1 - 1e-12) - 1e-9)) + (shift == 0 ? 0 : 1);
  if (!(cells <= kMostCells))
    throw ComputationError("a pupil pitch of " + format_quantity(pitch, Dimension::kLength) +
                           " gives more than " + std::to_string(kMostCells) + " grid points per side");
  const double first = 0.5 * (low + high) + (shift - 0.5 * (cells - 1)) * pitch;
  return first + pitch * Eigen::ArrayXd::LinSpaced(Eigen::Index(cells), 0.0, cells - 1);
}

// Radius of the cone of rays from the rim, over the distance from the focus.
double steepness_of_rim(const Aperture& aperture, double focal_length) {
  const double t = aperture_radius(aperture) / (2 * focal_length);
  return aperture_radius(aperture) / (focal_length * std::max(1 - t * t, kLeastCosine));
}

}  // namespace

DiffractionPupil diffraction_pupil(const Aperture& aperture, double focal_length, double pitch,
                                   std::array<double, 2> shift) {
  if (!(pitch > 0)) throw ComputationError("a pupil grid needs a pitch above zero");
  if (!(std::abs(shift[0]) <= 0.5 && std::abs(shift[1]) <= 0.5))
    throw ComputationError("a pupil grid may be shifted by at most half a pixel");
  if (!(focal_length > 0)) throw ComputationError("a pupil grid needs a focal length above zero");
  if (!(aperture_radius(aperture) < kDeepest * focal_length))
    throw ComputationError(
        "a mirror of radius " + format_quantity(aperture_radius(aperture), Dimension::kLength) +
        " and focal length " + format_quantity(focal_length, Dimension::kLength) +
        " is too deep for a pupil of direction cosines; the radius must stay below " + "1.9 focal lengths");
  const Aperture shape = in_directions(aperture, focal_length, kChord * pitch);
  const ApertureBox box = bounding_box(shape);
  PupilBuilder builder(cell_centres(box.x0, box.x1, pitch, shift[0]),
                       cell_centres(box.y0, box.y1, pitch, shift[1]), pitch, pitch);
  if (const std::shared_ptr<const Segments> segments = erring_segments(aperture)) {
    for (const Segments::Segment& segment : segments->all())
      builder.add_segment(in_directions(SegmentedAperture{segment.clear}, focal_length, kChord * pitch));
  } else {
    builder.add_all(shape);
  }
  builder.pupil().total = aperture_area(aperture) / (pitch * pitch);
  return builder.finish(focal_length, shift);
}

DiffractionPupil diffraction_pupil(const HeightMap& map, const Aperture& aperture, Eigen::ArrayXd* height) {
  if (!(map.pitch_x > 0) || !(map.pitch_y > 0))
    throw ComputationError("a map needs a pitch before its PSF can be computed");
  const auto axis = [](Eigen::Index n, double first, double pitch) -> Eigen::ArrayXd {
    return first + pitch * Eigen::ArrayXd::LinSpaced(n, 0.0, double(n - 1));
  };
  PupilBuilder builder(axis(map.columns(), map.x0, map.pitch_x), axis(map.rows(), map.y0, map.pitch_y),
                       map.pitch_x, map.pitch_y);
  const ApertureCells cells(aperture, builder.grid().x, builder.grid().y, map.pitch_x, map.pitch_y);
  std::vector<double> values;
  double found = 0;
  for (Eigen::Index row = 0; row < map.rows(); ++row) {
    for (Eigen::Index column = 0; column < map.columns(); ++column) {
      if (!std::isfinite(map.height(row, column))) continue;
      const ClearPart clear = cells(column, row);
      if (!(clear.share > 0)) continue;
      builder.add(column, row, clear);
      values.push_back(map.height(row, column));
      found += clear.share;
    }
  }
  const double whole = aperture_area(aperture) / (map.pitch_x * map.pitch_y);
  builder.pupil().missing = std::max(0.0, 1.0 - found / whole);
  builder.pupil().total = found;
  *height = Eigen::Map<Eigen::ArrayXd>(values.data(), Eigen::Index(values.size()));
  return builder.finish(kParaxial, {0, 0});
}

double farthest_plane(const Aperture& aperture, double focal_length, double wavelength, int samples) {
  const double steepness = steepness_of_rim(aperture, focal_length);
  const double in_far_field = samples * wavelength / (8 * aperture_radius(aperture) * steepness);
  return focal_length * in_far_field / (1 + in_far_field);  // inside focus, where the field is smaller
}

DiffractionSampling diffraction_sampling(const Aperture& aperture, double focal_length, double wavelength,
                                         double radius, double dz, int least_samples) {
  const double aperture_r = aperture_radius(aperture), distance = focal_length + dz;
  // A ray at the distance w/2 from the focus, w = wavelength distance/pitch the field of view, changes the
  // phase by pi from cell to cell. We allow half of that, which leaves room for a Gaussian tail or the
  // scatter of a realisation.
  const double reach = radius + std::abs(dz) * steepness_of_rim(aperture, focal_length);
  const double for_reach = 8 * aperture_r * reach / (wavelength * distance);
  DiffractionSampling result;
  result.samples = int(std::ceil(std::max(for_reach, double(least_samples))));
  result.samples += result.samples % 2;
  result.pitch = 2 * aperture_r / result.samples;
  result.reason =
      std::to_string(result.samples) + " grid points across the aperture: " +
      (for_reach > least_samples ? "energy as far as " + format_quantity(reach, Dimension::kLength) +
                                       " from the focus stays inside half of the field of view"
                                 : std::string("the aperture's edge needs at least that many"));
  return result;
}

}  // namespace aberfit
