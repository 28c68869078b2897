#include "aberfit/report/exports.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "aberfit/core/constants.h"
#include "aberfit/terms/derivatives.h"
#include "aberfit/terms/surface_operator.h"
#include "coefficient_listing.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr int kLeastGrid = 5;  // OpticStudio's smallest grid
// Number of cells beyond the rim that keep their values in a grid sag. If the aperture is wider than two
// pitches, the corners of any cell on it are within two cells of a grid point inside.
constexpr int kRimCells = 2;
// Zernikes grow as rho^n beyond the rim. A value this many times the largest inside is useless.
constexpr double kRimGrowth = 1e3;

void check(const ExportInput& input) {
  if (!(input.wavelength > 0) || !std::isfinite(input.wavelength))
    throw std::invalid_argument(fmt::format("export: wavelength {} m; needs one above 0", input.wavelength));
  if (input.grid_size < kLeastGrid)
    throw std::invalid_argument(
        fmt::format("export: {} grid points per side; at least {}", input.grid_size, kLeastGrid));
  if (input.coefficients.size() != input.terms.size())
    throw std::invalid_argument(
        fmt::format("export: {} coefficients for {} terms", input.coefficients.size(), input.terms.size()));
  if (!input.coefficients.allFinite())
    throw std::invalid_argument("export: a coefficient is not a finite number");
}

struct Square {
  double x = 0, y = 0;  // middle [m]
  double side = 0;      // [m]
};

Square bounding_square(const Aperture& aperture) {
  const ApertureBox box = bounding_box(aperture);
  return {0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1), std::max(box.x1 - box.x0, box.y1 - box.y0)};
}

using Mask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The empty map (all NaN) over the square around the aperture.
HeightMap empty_map(const ExportInput& input) {
  const Square square = bounding_square(input.aperture);
  HeightMap map;
  map.height = Grid::Constant(input.grid_size, input.grid_size, kNaN);
  map.pitch_x = map.pitch_y = square.side / (input.grid_size - 1);
  map.x0 = square.x - 0.5 * square.side;
  map.y0 = square.y - 0.5 * square.side;
  map.label = one_line(input.title, 80);
  return map;
}

// Grid points of the clear aperture, including those on its rim despite rounding. The edge margin is only for
// rays.
Mask inside_aperture(const HeightMap& map, const Aperture& aperture) {
  constexpr double kTowardsMiddle = 1 - 1e-12;
  const double x_middle = 0.5 * (map.x(0) + map.x(map.columns() - 1));
  const double y_middle = 0.5 * (map.y(0) + map.y(map.rows() - 1));
  Mask inside(map.rows(), map.columns());
  for (Eigen::Index row = 0; row < map.rows(); ++row)
    for (Eigen::Index column = 0; column < map.columns(); ++column) {
      const double x = map.x(column), y = map.y(row);
      inside(row, column) = aperture_contains(aperture, x, y, 0) ||
                            aperture_contains(aperture, x_middle + kTowardsMiddle * (x - x_middle),
                                              y_middle + kTowardsMiddle * (y - y_middle), 0);
    }
  return inside;
}

// Points within `cells` rows and columns of a marked one.
Mask widened(const Mask& mask, Eigen::Index cells) {
  Mask wide = Mask::Constant(mask.rows(), mask.cols(), false);
  for (Eigen::Index row = 0; row < mask.rows(); ++row)
    for (Eigen::Index column = 0; column < mask.cols(); ++column) {
      if (!mask(row, column)) continue;
      const Eigen::Index top = std::max<Eigen::Index>(row - cells, 0);
      const Eigen::Index left = std::max<Eigen::Index>(column - cells, 0);
      wide.block(top, left, std::min(row + cells + 1, mask.rows()) - top,
                 std::min(column + cells + 1, mask.cols()) - left) = true;
    }
  return wide;
}

struct Points {
  std::vector<Eigen::Index> index;  // row * columns + column
  Eigen::ArrayXd x, y;              // [m]
};

Points marked_points(const HeightMap& map, const Mask& mask) {
  Points points;
  for (Eigen::Index i = 0; i < mask.size(); ++i)
    if (mask.data()[i]) points.index.push_back(i);
  points.x.resize(Eigen::Index(points.index.size()));
  points.y.resize(points.x.size());
  for (Eigen::Index k = 0; k < points.x.size(); ++k) {
    points.x[k] = map.x(points.index[std::size_t(k)] % map.columns());
    points.y[k] = map.y(points.index[std::size_t(k)] / map.columns());
  }
  return points;
}

SurfaceField surface_at(const ExportInput& input, const Points& points) {
  SurfaceField field;
  field.resize(points.x.size());
  if (input.terms.size() == 0) {
    field.height.setZero(), field.slope_x.setZero(), field.slope_y.setZero();
  } else if (points.x.size() > 0) {
    SurfaceOperator(input.terms, points.x, points.y).apply(input.coefficients, &field);
  }
  return field;
}

// Heights alone, without data outside the aperture, for formats that are not interpolated across its rim.
HeightMap sample_heights(const ExportInput& input) {
  check(input);
  HeightMap map = empty_map(input);
  const Points points = marked_points(map, inside_aperture(map, input.aperture));
  const SurfaceField field = surface_at(input, points);
  for (std::size_t k = 0; k < points.index.size(); ++k)
    map.height.data()[points.index[k]] = field.height[Eigen::Index(k)];
  return map;
}

}  // namespace

GridSag sample_surface(const ExportInput& input) {
  check(input);
  GridSag sag;
  sag.map = empty_map(input);
  const Mask inside = inside_aperture(sag.map, input.aperture);
  const Points points = marked_points(sag.map, widened(inside, kRimCells));
  const SurfaceField field = surface_at(input, points);
  const Eigen::ArrayXd twist = input.terms.size() == 0
                                   ? Eigen::ArrayXd::Zero(points.x.size())
                                   : cross_derivative(input.terms, input.coefficients, points.x, points.y);

  double largest = 0;
  for (std::size_t k = 0; k < points.index.size(); ++k)
    if (inside.data()[points.index[k]]) largest = std::max(largest, std::abs(field.height[Eigen::Index(k)]));
  sag.dx = sag.dy = sag.dxdy = Grid::Constant(input.grid_size, input.grid_size, kNaN);
  for (std::size_t k = 0; k < points.index.size(); ++k) {
    const Eigen::Index i = points.index[k], j = Eigen::Index(k);
    const bool finite = std::isfinite(field.height[j]) && std::isfinite(field.slope_x[j]) &&
                        std::isfinite(field.slope_y[j]) && std::isfinite(twist[j]);
    if (!finite || (!inside.data()[i] && std::abs(field.height[j]) > kRimGrowth * largest)) continue;
    sag.map.height.data()[i] = field.height[j];
    sag.dx.data()[i] = field.slope_x[j];
    sag.dy.data()[i] = field.slope_y[j];
    sag.dxdy.data()[i] = twist[j];
  }
  return sag;
}

namespace internal {

std::vector<ZernikeCoefficient> as_zernikes(const ExportInput& input, const std::string& format) {
  check(input);
  const auto refuse = [&](const char* what) {
    throw std::invalid_argument(format + ": " + what +
                                "; export zemax-grid-sag, codev-int, fits-opd or csv instead");
  };
  if (!input.terms.fourier.empty()) refuse("Fourier terms are not a finite sum of Zernikes");
  if (input.terms.of_a_segment() > 0) refuse("segments with errors of their own are not a sum of Zernikes");
  if (!(input.terms.radius > 0))
    throw std::invalid_argument(format + ": the terms have no normalization radius");
  std::vector<ZernikeCoefficient> result;
  for (std::size_t i = 0; i < input.terms.zernike.size(); ++i)
    result.push_back({input.terms.zernike[i], input.coefficients[Eigen::Index(i)]});
  for (std::size_t i = 0; i < input.terms.spherical.size(); ++i) {
    const double height = input.coefficients[input.terms.spherical_begin() + Eigen::Index(i)];
    const int k = input.terms.spherical[i] / 2;
    double share = 1.0 / (k + 1.0);  // k!^2 / ((k - l)! (k + l + 1)!), from l = 0 up
    for (int l = 0; l <= k; ++l) {
      result.push_back({{2 * l, 0}, height * std::sqrt(2.0 * l + 1.0) * share});
      share *= double(k - l) / (k + l + 2.0);
    }
  }
  return result;
}

std::string one_line(const std::string& title, std::size_t limit) {
  std::string line;
  for (const char c : title) line += c >= ' ' && c <= '~' ? c : ' ';
  // A leading "!" would make it a comment in most of these formats.
  const std::size_t begin = line.find_first_not_of(" !");
  if (begin == std::string::npos) return "aberfit surface";
  line = line.substr(begin, limit);
  return line.substr(0, line.find_last_not_of(' ') + 1);
}

}  // namespace internal

const std::string& export_file_name(ExportFormat format) {
  static const std::vector<std::string> names = {
      "grid_sag.DAT", "zernike_standard.txt", "surface.int", "zernike_fringe.int", "opd.fits", "surface.csv"};
  return names[std::size_t(format)];
}

std::pair<std::string, std::string> export_file(ExportFormat format, const ExportInput& input) {
  const std::string& name = export_file_name(format);
  switch (format) {
    case ExportFormat::kZemaxGridSag:
      return {name,
              zemax_grid_sag_text(sample_surface(input),
                                  one_line(input.title, 80) + "; sag along +z, towards the incoming light")};
    case ExportFormat::kZernikeNoll:
      return {name, zernike_listing_text(input)};
    case ExportFormat::kCodeVInt: {
      const HeightMap map = sample_heights(input);
      // The format has no lateral size, so the title carries it.
      const double side_mm = map.pitch_x * (input.grid_size - 1) * 1e3;
      return {name, codev_int_text(map, input.wavelength,
                                   fmt::format("{} (side {:.6g} mm)", one_line(input.title, 50), side_mm))};
    }
    case ExportFormat::kCodeVZfr:
      return {name, codev_zfr_text(input)};
    case ExportFormat::kFitsOpd:
      return {name, fits_opd_bytes(sample_heights(input))};
    case ExportFormat::kCsv:
      return {name, map_csv(sample_heights(input))};
  }
  throw std::invalid_argument("export: an unknown format");
}

}  // namespace aberfit
