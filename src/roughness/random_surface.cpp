#include "aberfit/roughness/random_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <string>

#include "aberfit/core/random.h"
#include "aberfit/core/smooth_number.h"
#include "aberfit/roughness/fourier_transform.h"
#include "aberfit/roughness/line_kernel.h"
#include "aberfit/roughness/spectrum_cells.h"
#include "profile_spectrum.h"

namespace aberfit {
using namespace internal;

namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

// Grid cells this near to zero frequency, in frequency steps, are integrated exactly. Beyond, two nodes per
// side have an error of 4e-5 of a cell for S ~ f^-4.
constexpr double kLowCells = 8;
// A coarser grid replaces the frequency ordinates up to this one. A smaller number concentrates the coarser
// grid's waves more at its lowest frequencies.
constexpr Eigen::Index kReplaced = 2;

/// Variance between the frequencies x0..x1 and y0..y1, all >= 0, in one quadrant.
using QuadrantVariance = std::function<double(double x0, double x1, double y0, double y1)>;

struct Lattice {
  Eigen::Index rows, columns;  ///< size of the map
  Eigen::Index oversize;
  bool line;  ///< one row, without waves across it
  double pitch;
};

// A random amplitude with E |c|^2 = variance of one ordinate; real where the ordinate mirrors itself.
Complex amplitude(SpectrumDraw draw, const RandomStream& stream, std::uint64_t index, double variance,
                  bool own_mirror) {
  if (draw == SpectrumDraw::kPhaseOnly) {
    const double u = stream.uniform(index), a = std::sqrt(variance);
    return own_mirror ? Complex(u < 0.5 ? -a : a) : std::polar(a, 2 * pi * u);
  }
  const auto [re, im] = stream.normal_pair(index);
  return own_mirror ? Complex(std::sqrt(variance) * re) : std::sqrt(0.5 * variance) * Complex(re, im);
}

// Quadrant variances of the frequency cells of the first grid, (j, k) for frequencies j/(rows pitch),
// k/(columns pitch). Cells end at 1/(2 pitch), so the last one of an even size is half a cell.
Grid cell_variances(const QuadrantVariance& variance, Eigen::Index rows, Eigen::Index columns, double pitch) {
  const auto edges = [pitch](Eigen::Index k, Eigen::Index n) {
    const double step = 1 / (double(n) * pitch);
    return std::array{std::max(0.0, double(k) - 0.5) * step,
                      std::min(double(k) + 0.5, 0.5 * double(n)) * step};
  };
  Grid cells(rows / 2 + 1, columns / 2 + 1);
  for (Eigen::Index j = 0; j < cells.rows(); ++j)
    for (Eigen::Index k = 0; k < cells.cols(); ++k) {
      if (rows == columns && k < j) {  // isotropic
        cells(j, k) = cells(k, j);
        continue;
      }
      const auto y = edges(j, rows), x = edges(k, columns);
      cells(j, k) = j == 0 && k == 0 ? 0 : variance(x[0], x[1], y[0], y[1]);
    }
  return cells;
}

// Half of the spectrum of the first grid: ordinates (j, k), k = 0 .. columns/2. The rest is the mirror image.
// Each pair has one random number, with the index of the first of the two in row order. Ordinates that are
// their own mirror image (zero and, in even sizes, Nyquist) are real and hold the variance of both signs.
// Calls put(j, k, value).
template <typename Put>
void draw_spectrum(const Grid& cells, Eigen::Index rows, Eigen::Index columns,
                   const RandomSurfaceOptions& options, const Put& put) {
  const RandomStream stream(options.seed, "random-surface");
  const Eigen::Index half = columns / 2;
  const bool gaussian = options.draw == SpectrumDraw::kGaussian;
  std::vector<double> re(static_cast<std::size_t>(columns)), im(re.size());
  for (Eigen::Index j = 0; 2 * j <= rows; ++j) {
    const Eigen::Index opposite = (rows - j) % rows;
    const bool own_row = opposite == j;
    const Eigen::Index last = own_row ? half : columns - 1;
    if (gaussian) stream.normal_pairs(std::uint64_t(j * columns), int(last + 1), re.data(), im.data());
    for (Eigen::Index k = 0; k <= last; ++k) {
      const Eigen::Index k_mirror = (columns - k) % columns, column = std::min(k, k_mirror);
      const bool own_column = k == k_mirror;
      const double variance = cells(j, column) * (own_row ? 2 : 1) * (own_column ? 2 : 1);
      Complex c;
      if (!gaussian)
        c = amplitude(options.draw, stream, std::uint64_t(j * columns + k), variance, own_row && own_column);
      else if (own_row && own_column)
        c = std::sqrt(variance) * re[std::size_t(k)];
      else
        c = std::sqrt(0.5 * variance) * Complex(re[std::size_t(k)], im[std::size_t(k)]);
      if (k <= half) put(j, k, c);
      // The mirror image, if it is in this half too.
      if (k_mirror <= half && !(own_row && own_column)) put(opposite, k_mirror, std::conj(c));
    }
  }
}

// The real transform along columns and rows, several lines together; only the part that the map needs.
Grid transformed(const Grid& cells, const Lattice& map, Eigen::Index rows, Eigen::Index columns,
                 const RandomSurfaceOptions& options) {
  const LineKernels<double>& kernels = line_kernels<double>(best_instruction_set());
  const LinePlan<double> along_y{int(rows)}, along_x{int(columns)};
  const Eigen::Index blocks = (columns / 2 + kLines) / kLines, bundle = 2 * kLines;
  const long stride =
      blocks * bundle + kLines;            // not a power of two, which would map all rows to one cache line
  Eigen::ArrayXd spectrum(rows * stride);  // columns are transformed in place
  spectrum.setZero();
  draw_spectrum(cells, rows, columns, options, [&](Eigen::Index j, Eigen::Index k, Complex c) {
    double* to = spectrum.data() + j * stride + k / kLines * bundle + k % kLines;
    to[0] = c.real();
    to[kLines] = c.imag();
  });
  Eigen::ArrayXd work(2 * kLines * (3 * std::max(rows, columns) + 3 * kLines));
  const std::vector<double> none = line_phases<double>(int(rows), 0, 1);
  for (Eigen::Index block = 0; block < blocks; ++block)
    kernels.columns_out(along_y.steps(), none.data(), 1, spectrum.data() + block * bundle, stride, int(rows),
                        spectrum.data() + block * bundle, stride, work.data());
  Grid height(map.rows, map.columns);
  for (Eigen::Index first = 0; first < map.rows; first += 2 * kLines) {
    const double* from[2][kLines];
    double* to[2][kLines];
    for (Eigen::Index line = 0; line < 2 * kLines; ++line) {
      const bool there = first + line < map.rows;
      from[line / kLines][line % kLines] = there ? spectrum.data() + (first + line) * stride : nullptr;
      to[line / kLines][line % kLines] = there ? &height(first + line, 0) : nullptr;
    }
    kernels.real_rows(along_x.steps(), from[0], from[1], to[0], to[1], int(map.columns), work.data());
  }
  return height;
}

// The waves of the first grid, cut to the map.
Grid first_grid(const Grid& cells, const Lattice& map, Eigen::Index rows, Eigen::Index columns,
                const RandomSurfaceOptions& options) {
  if (is_smooth(rows) && is_smooth(columns)) return transformed(cells, map, rows, columns, options);
  std::vector<Complex> values(std::size_t(rows * columns));
  draw_spectrum(cells, rows, columns, options, [&](Eigen::Index j, Eigen::Index k, Complex c) {
    values[std::size_t(j * columns + k)] = c;
    values[std::size_t((rows - j) % rows * columns + (columns - k) % columns)] = std::conj(c);
  });
  fourier_transform(int(rows), int(columns), values.data());
  Grid height(map.rows, map.columns);
  for (Eigen::Index j = 0; j < map.rows; ++j)
    for (Eigen::Index k = 0; k < map.columns; ++k) height(j, k) = values[std::size_t(j * columns + k)].real();
  return height;
}

// Frequency cells of a coarser grid along one axis, one step wide and cut at the rectangle they fill.
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

// Adds the waves of a coarser grid one by one at the points of the map, because they are few.
void add_waves(const QuadrantVariance& variance, const Axis& x, const Axis& y, Eigen::Index inner_x,
               Eigen::Index inner_y, const RandomStream& stream, SpectrumDraw draw, double pitch,
               Grid* height) {
  Eigen::MatrixXcd waves = Eigen::MatrixXcd::Zero(2 * y.size() - 1, x.size());  // rows: -y .. y
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

// S(f) by cubic interpolation of samples `spacing` apart; S itself without samples and next to breakpoints.
// Cells are at least seven steps from zero. Eight samples per step give S ~ f^-4 to 2e-6.
constexpr double kSamplesPerStep = 8;
class PsdTable {
 public:
  PsdTable(const RadialPsd& psd, double low, double high, double spacing)
      : psd_(psd), low_(low), per_sample_(1 / spacing) {
    constexpr double kMostSamples = 1 << 20;
    const double samples = (high - low) / spacing + 4;
    if (!(high > low && samples < kMostSamples)) return;
    values_.resize(std::size_t(samples));
    for (std::size_t i = 0; i < values_.size(); ++i) values_[i] = psd(low + double(i) * spacing);
    smooth_.assign(values_.size(), 1);
    for (const double f : psd.breakpoints()) {
      const double at = (f - low) * per_sample_;
      for (double i = std::floor(at) - 2; i <= std::floor(at) + 2; ++i)
        if (i >= 0 && i < double(smooth_.size())) smooth_[std::size_t(i)] = 0;
    }
  }
  double operator()(double f) const {
    const double t = (f - low_) * per_sample_;
    if (!(t >= 1 && t < double(values_.size()) - 2)) return psd_(f);
    const auto i = std::size_t(t);
    if (!smooth_[i]) return psd_(f);
    const double u = t - double(i), *v = values_.data() + i;
    const double below = v[-1], at = v[0], above = v[1], beyond = v[2];
    const double cubic =
        at + u * ((above - at) + (u - 1) * (0.5 * (above - 2 * at + below) +
                                            (u + 1) / 6 * (beyond - 3 * above + 3 * at - below)));
    return std::max(0.0, cubic);
  }

 private:
  const RadialPsd& psd_;
  double low_, per_sample_;
  std::vector<double> values_;
  std::vector<char> smooth_;
};

constexpr double kGaussNode = 0.288675134594812882;  // node of two on [-1/2, 1/2], 1/sqrt(12)

}  // namespace

HeightMap random_surface(const RadialPsd& psd, Eigen::Index rows, Eigen::Index columns, double pitch,
                         const RandomSurfaceOptions& options) {
  check(rows, columns, pitch, options);
  const double step = 1 / (double(std::max(rows, columns) * options.oversize) * pitch);
  const PsdTable table(psd, (kLowCells - 1) * step, std::numbers::sqrt2 / (2 * pitch),
                       step / kSamplesPerStep);
  const QuadrantVariance variance = [&psd, &table, jump = jumps(psd)](double x0, double x1, double y0,
                                                                      double y1) {
    const double inner = std::hypot(x0, y0), outer = std::hypot(x1, y1);
    if (outer <= psd.f_min() || inner >= psd.f_max()) return 0.0;
    if ((low_cell(x0, x1) && low_cell(y0, y1)) || jumps_between(jump, inner, outer))
      return rectangle_variance(psd, x0, x1, y0, y1);
    double sum = 0;
    for (const double s : {-kGaussNode, kGaussNode})
      for (const double t : {-kGaussNode, kGaussNode}) {
        const double x = 0.5 * (x0 + x1) + s * (x1 - x0), y = 0.5 * (y0 + y1) + t * (y1 - y0);
        sum += table(std::sqrt(x * x + y * y));
      }
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
  // S1 has an infinite slope at a frequency where S jumps. The factor is a quarter, because S1 is one-sided
  // and the grid of one row counts its only row twice.
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
