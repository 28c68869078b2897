#include "aberfit/roughness/random_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <string>

#include "aberfit/core/quadrature.h"
#include "aberfit/core/random.h"
#include "aberfit/roughness/fourier_transform.h"
#include "profile_spectrum.h"
#include "spectrum_cells.h"

namespace aberfit {
using namespace internal;

namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

// Cells so near to zero frequency, in frequency steps, are integrated exactly; beyond, two nodes a side leave
// 4e-5 of a cell for S ~ f^-4.
constexpr double kLowCells = 8;
// A coarser grid takes over the ordinates up to this one: the fewer, the more its waves crowd at its lowest.
constexpr Eigen::Index kReplaced = 2;

/// Variance between the frequencies x0..x1 and y0..y1, all >= 0: one quadrant.
using QuadrantVariance = std::function<double(double x0, double x1, double y0, double y1)>;

struct Lattice {
  Eigen::Index rows, columns;  ///< of the map
  Eigen::Index oversize;
  bool line;  ///< one row, and no waves across
  double pitch;
};

// One draw of 2 amplitudes: E |c|^2 = variance of one ordinate; real where an ordinate is its own mirror
// image.
Complex amplitude(SpectrumDraw draw, const RandomStream& stream, std::uint64_t index, double variance,
                  bool own_mirror) {
  if (draw == SpectrumDraw::kPhaseOnly) {
    const double u = stream.uniform(index), a = std::sqrt(variance);
    return own_mirror ? Complex(u < 0.5 ? -a : a) : std::polar(a, 2 * pi * u);
  }
  const auto [re, im] = stream.normal_pair(index);
  return own_mirror ? Complex(std::sqrt(variance) * re) : std::sqrt(0.5 * variance) * Complex(re, im);
}

// Quadrant variances of the cells of the first grid, (j, k) for frequencies j/(rows pitch), k/(columns
// pitch). Cells end at 1/(2 pitch): the last one of an even size is half a cell.
Grid cell_variances(const QuadrantVariance& variance, Eigen::Index rows, Eigen::Index columns, double pitch) {
  const auto edges = [pitch](Eigen::Index k, Eigen::Index n) {
    const double step = 1 / (double(n) * pitch);
    return std::array{std::max(0.0, double(k) - 0.5) * step,
                      std::min(double(k) + 0.5, 0.5 * double(n)) * step};
  };
  Grid cells(rows / 2 + 1, columns / 2 + 1);
  for (Eigen::Index j = 0; j < cells.rows(); ++j)
    for (Eigen::Index k = 0; k < cells.cols(); ++k) {
      const auto y = edges(j, rows), x = edges(k, columns);
      cells(j, k) = j == 0 && k == 0 ? 0 : variance(x[0], x[1], y[0], y[1]);
    }
  return cells;
}

// Waves of the first grid, cut to the map. Hermitian by construction: each ordinate is drawn once, with its
// mirror image, and those that are their own image (zero and, in even sizes, Nyquist) are real and hold the
// cells of both signs.
Grid first_grid(const Grid& cells, const Lattice& map, Eigen::Index rows, Eigen::Index columns,
                const RandomSurfaceOptions& options) {
  const RandomStream stream(options.seed, "random-surface");
  std::vector<Complex> values(std::size_t(rows * columns));
  for (Eigen::Index j = 0; j < rows; ++j)
    for (Eigen::Index k = 0; k < columns; ++k) {
      const Eigen::Index j_mirror = (rows - j) % rows, k_mirror = (columns - k) % columns;
      const Eigen::Index here = j * columns + k, mirror = j_mirror * columns + k_mirror;
      if (mirror < here) continue;
      const double cell = cells(std::min(j, j_mirror), std::min(k, k_mirror));
      const Complex c = amplitude(options.draw, stream, std::uint64_t(here),
                                  cell * (j == j_mirror ? 2 : 1) * (k == k_mirror ? 2 : 1), mirror == here);
      values[std::size_t(here)] = c;
      values[std::size_t(mirror)] = std::conj(c);
    }
  fourier_transform(int(rows), int(columns), values.data());
  Grid height(map.rows, map.columns);
  for (Eigen::Index j = 0; j < map.rows; ++j)
    for (Eigen::Index k = 0; k < map.columns; ++k) height(j, k) = values[std::size_t(j * columns + k)].real();
  return height;
}

// Cells of a coarser grid along one axis: step wide around multiples of it, cut at the rectangle they fill.
struct Axis {
  std::vector<double> low, high;
  double centre(Eigen::Index k) const {
    return k == 0 ? 0 : 0.5 * (low[std::size_t(k)] + high[std::size_t(k)]);
  }
  Eigen::Index size() const { return Eigen::Index(low.size()); }
};

Axis axis_of(double end, double step, bool only_zero) {
  Axis axis;
  for (int k = 0; k == 0 || (!only_zero && (k - 0.5) * step < end * (1 - 1e-12)); ++k) {
    axis.low.push_back(std::max(0.0, k - 0.5) * step);
    axis.high.push_back(std::min((k + 0.5) * step, end));
  }
  return axis;
}

// Adds the waves of a coarser grid, evaluated one by one at the points of the map: there are few of them, and
// so nothing is interpolated.
void add_waves(const QuadrantVariance& variance, const Axis& x, const Axis& y, Eigen::Index inner_x,
               Eigen::Index inner_y, const RandomStream& stream, SpectrumDraw draw, double pitch,
               Grid* height) {
  Eigen::MatrixXcd waves = Eigen::MatrixXcd::Zero(2 * y.size() - 1, x.size());  // row: -y .. y
  const Eigen::Index zero = y.size() - 1;
  for (Eigen::Index j = -zero; j <= zero; ++j)
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const Eigen::Index across = std::abs(j);
      if ((across <= inner_y && k <= inner_x) || (k == 0 && j < 0)) continue;
      const double cell = variance(x.low[std::size_t(k)], x.high[std::size_t(k)], y.low[std::size_t(across)],
                                   y.high[std::size_t(across)]);
      waves(j + zero, k) = amplitude(draw, stream, std::uint64_t((j + zero) * x.size() + k),
                                     cell * (j == 0 ? 2 : 1) * (k == 0 ? 2 : 1), false);
    }
  Eigen::MatrixXcd along_y(height->rows(), 2 * y.size() - 1), along_x(x.size(), height->cols());
  for (Eigen::Index j = -zero; j <= zero; ++j)
    for (Eigen::Index r = 0; r < height->rows(); ++r)
      along_y(r, j + zero) =
          std::polar(1.0, 2 * pi * (j < 0 ? -1 : 1) * y.centre(std::abs(j)) * double(r) * pitch);
  for (Eigen::Index k = 0; k < x.size(); ++k)
    for (Eigen::Index c = 0; c < height->cols(); ++c)
      along_x(k, c) = std::polar(1.0, 2 * pi * x.centre(k) * double(c) * pitch);
  const Eigen::MatrixXcd at_rows = along_y * waves;
  height->matrix() += 2 * (at_rows.real() * along_x.real() - at_rows.imag() * along_x.imag());
}

Grid draw_heights(const QuadrantVariance& variance, const Lattice& map, const RandomSurfaceOptions& options) {
  const Eigen::Index columns = map.columns * map.oversize, rows = map.line ? 1 : map.rows * map.oversize;
  Grid cells = cell_variances(variance, rows, columns, map.pitch);
  Eigen::Index inner_x = std::min(kReplaced, (columns - 1) / 2),
               inner_y = std::min(kReplaced, (rows - 1) / 2);
  if (options.scales > 1) cells.topLeftCorner(inner_y + 1, inner_x + 1).setZero();
  Grid height = first_grid(cells, map, rows, columns, options);
  double step_x = 1 / (double(columns) * map.pitch), step_y = 1 / (double(rows) * map.pitch);
  const double shrink = 1 / double(std::max(2, options.oversize));
  for (int scale = 1; scale < options.scales; ++scale) {
    const double end_x = (double(inner_x) + 0.5) * step_x, end_y = (double(inner_y) + 0.5) * step_y;
    step_x *= shrink;
    step_y *= shrink;
    const Axis x = axis_of(end_x, step_x, false), y = axis_of(end_y, step_y, map.line);
    const bool last = scale + 1 == options.scales;
    inner_x = last ? 0 : std::min(kReplaced, x.size() - 2);
    inner_y = last || map.line ? 0 : std::min(kReplaced, y.size() - 2);
    const RandomStream stream(options.seed, "random-surface-scale-" + std::to_string(scale));
    add_waves(variance, x, y, inner_x, inner_y, stream, options.draw, map.pitch, &height);
  }
  return height;
}

void check(Eigen::Index rows, Eigen::Index columns, double pitch, const RandomSurfaceOptions& options) {
  if (rows < 1 || columns < 1) throw std::invalid_argument("a random surface needs at least one point");
  if (!(pitch > 0)) throw std::invalid_argument("the pitch of a random surface must be positive");
  if (options.oversize < 1 || options.scales < 1)
    throw std::invalid_argument("oversize and scales of a random surface start at 1");
}

bool low_cell(double lower, double upper) { return lower < kLowCells * (upper - lower); }

bool jumps_between(const std::vector<double>& jump, double lower, double upper) {
  const auto next = std::upper_bound(jump.begin(), jump.end(), lower);
  return next != jump.end() && *next < upper;
}

constexpr double kGaussNode = 0.288675134594812882;  // of two on [-1/2, 1/2], 1/sqrt(12)

}  // namespace

HeightMap random_surface(const RadialPsd& psd, Eigen::Index rows, Eigen::Index columns, double pitch,
                         const RandomSurfaceOptions& options) {
  check(rows, columns, pitch, options);
  const QuadrantVariance variance = [&psd, jump = jumps(psd)](double x0, double x1, double y0, double y1) {
    const double inner = std::hypot(x0, y0), outer = std::hypot(x1, y1);
    if (outer <= psd.f_min() || inner >= psd.f_max()) return 0.0;
    if ((low_cell(x0, x1) && low_cell(y0, y1)) || jumps_between(jump, inner, outer))
      return rectangle_variance(psd, x0, x1, y0, y1);
    double sum = 0;
    for (const double s : {-kGaussNode, kGaussNode})
      for (const double t : {-kGaussNode, kGaussNode})
        sum += psd(std::hypot(0.5 * (x0 + x1) + s * (x1 - x0), 0.5 * (y0 + y1) + t * (y1 - y0)));
    return 0.25 * sum * (x1 - x0) * (y1 - y0);
  };
  HeightMap map;
  map.height = draw_heights(variance, {rows, columns, options.oversize, false, pitch}, options);
  map.pitch_x = map.pitch_y = pitch;
  map.x0 = -0.5 * pitch * double(columns - 1);
  map.y0 = -0.5 * pitch * double(rows - 1);
  map.label = "random surface";
  return map;
}

Profile random_profile(const RadialPsd& psd, Eigen::Index points, double pitch,
                       const RandomSurfaceOptions& options) {
  check(1, points, pitch, options);
  // S1 bends sharply, with infinite slope, at a frequency where S jumps. A quarter: one-sided, and the
  // lattice of one row counts its only row twice.
  const double longest = double(points) * double(options.oversize) * pitch *
                         std::pow(std::max(2, options.oversize), options.scales - 1);
  const ProfileSpectrum s1(psd, 0.1 / longest);  // cells start at half a step of the largest grid
  const QuadrantVariance variance = [&s1, jump = jumps(psd)](double a, double b, double, double) {
    if (low_cell(a, b) || jumps_between(jump, a, b))
      return 0.25 * integral_in_pieces(std::cref(s1), a, b, jump);
    const double middle = 0.5 * (a + b), width = b - a;
    return 0.125 * width * (s1(middle - kGaussNode * width) + s1(middle + kGaussNode * width));
  };
  const Grid height = draw_heights(variance, {1, points, options.oversize, true, pitch}, options);
  Profile profile;
  profile.value = height.row(0).transpose();
  profile.x = pitch * (Eigen::ArrayXd::LinSpaced(points, 0, double(points - 1)) - 0.5 * double(points - 1));
  profile.label = "random profile";
  return profile;
}

}  // namespace aberfit
