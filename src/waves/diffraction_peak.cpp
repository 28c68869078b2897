#include "aberfit/waves/diffraction_peak.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <utility>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/fourier_transform.h"
#include "diffraction_peak_place.h"

namespace aberfit {
using namespace internal;

namespace {

using Complex = std::complex<double>;
using ComplexMatrix = Eigen::MatrixXcd;

// Samples are lambda (f/D)/2 apart, so the highest point is at most 0.354 lambda f/D from one. A function
// between 0 and M with no spectrum above the frequency nu falls from M no faster than M cos(pi nu x)^2
// (Duffin and Schaeffer 1938). For the irradiance nu is D/(lambda f). So maxima of the samples below 0.197 of
// the highest sample are not next to the highest point.
constexpr double kMayBeHighest = 0.197;
// Number of starting points in a speckle pattern; the highest parabolas through the samples come first.
constexpr std::size_t kMostStarts = 8;
constexpr int kMostSteps = 40;
constexpr double kStill = 1e-12;      // fraction of a sample at which Newton's steps end
constexpr double kOnAxis = 1e-9;      // of a sample
constexpr double kSameLight = 1e-13;  // relative; rounding of the sums

// A sum over the matrix with phases u and v per index, and its derivatives with respect to both.
struct PhasedSum {
  Complex value, u, v, uu, uv, vv;
};

// Rows and columns have integer or half-integer positions from the centre.
struct PlacedMatrix {
  ComplexMatrix value;
  Eigen::ArrayXd row, column;
  double sign = -1;  // sign of the phases

  PhasedSum at(double u, double v) const {
    Eigen::Matrix<Complex, Eigen::Dynamic, 3> along(value.rows(), 3);
    Eigen::Matrix<Complex, Eigen::Dynamic, 3> across(value.cols(), 3);
    const auto fill = [&](const Eigen::ArrayXd& place, double turn, auto* columns) {
      for (Eigen::Index k = 0; k < place.size(); ++k) {
        const Complex step(0, sign * place[k]), phase = std::polar(1.0, sign * turn * place[k]);
        (*columns)(k, 0) = phase;
        (*columns)(k, 1) = step * phase;
        (*columns)(k, 2) = step * step * phase;
      }
    };
    fill(row, u, &along);
    fill(column, v, &across);
    const Eigen::Matrix3cd sums = along.transpose() * (value * across);
    return {sums(0, 0), sums(1, 0), sums(0, 1), sums(2, 0), sums(1, 1), sums(0, 2)};
  }
};

// An irradiance with its gradient and second derivatives.
struct Hill {
  double value = 0;
  Eigen::Vector2d slope;
  Eigen::Matrix2d bend;
};

// |F|^2 of a field, with derivatives.
Hill hill_of_field(const PhasedSum& f) {
  const auto product = [](Complex a, Complex b) { return 2 * (std::conj(a) * b).real(); };
  Hill hill;
  hill.value = std::norm(f.value);
  hill.slope = {product(f.value, f.u), product(f.value, f.v)};
  const double uv = product(f.value, f.uv) + product(f.u, f.v);
  hill.bend << product(f.value, f.uu) + product(f.u, f.u), uv, uv, product(f.value, f.vv) + product(f.v, f.v);
  return hill;
}

// The real sum over the lags, with derivatives.
Hill hill_of_lags(const PhasedSum& f) {
  Hill hill;
  hill.value = f.value.real();
  hill.slope = {f.u.real(), f.v.real()};
  hill.bend << f.uu.real(), f.uv.real(), f.uv.real(), f.vv.real();
  return hill;
}

// The irradiance as a function of position, and samples of it.
class Landscape {
 public:
  Landscape(const DiffractionScene& scene, const DiffractionGrid& grid)
      : n_(fast_transform_size(2 * std::max(scene.rows(), scene.columns()))),
        has_scatter_(scene.problem().scatter != nullptr) {
    const CartesianGrid& cells = scene.grid();
    const auto places = [](int count) -> Eigen::ArrayXd {
      return Eigen::ArrayXd::LinSpaced(count, 0.0, double(count - 1)) - 0.5 * double(count - 1);
    };
    const FieldLayout layout{scene.rows(), scene.columns()};
    AlignedArray pupil(layout.size());
    std::fill_n(pupil.data(), layout.size(), 0.0);
    sums_.value = ComplexMatrix::Zero(scene.columns(), scene.rows());
    for (Eigen::Index k = 0; k < scene.points(); ++k) {
      const auto at = std::size_t(k);
      const Complex field = scene.base()[k];
      pupil.data()[scene.places()[at]] += field.real();
      pupil.data()[scene.places()[at] + kLines] += field.imag();
      sums_.value(cells.column[at], cells.row[at]) += field;
    }
    sums_.row = places(scene.columns());
    sums_.column = places(scene.rows());
    samples_ = focal_intensity(layout, pupil.data(), n_, 1, 0, n_);
    if (has_scatter_) scatter(grid);
  }

  Hill at(double u, double v) const {
    const PhasedSum sum = sums_.at(u, v);
    return has_scatter_ ? hill_of_lags(sum) : hill_of_field(sum);
  }
  double sample_step() const { return 2 * kPi / n_; }

  // Local maxima of the samples that may be next to the highest point, the highest first.
  std::vector<FocalPlace> starts() const {
    const double least = kMayBeHighest * samples_.maxCoeff();
    struct Maximum {
      double value;
      Eigen::Index row, column;
    };
    std::vector<Maximum> maxima;
    for (Eigen::Index row = 0; row < n_; ++row)
      for (Eigen::Index column = 0; column < n_; ++column)
        if (samples_(row, column) >= least && is_maximum(row, column))
          maxima.push_back({top_of_parabola(row, column), row, column});
    std::stable_sort(maxima.begin(), maxima.end(),
                     [](const Maximum& a, const Maximum& b) { return a.value > b.value; });
    if (maxima.size() > kMostStarts) maxima.resize(kMostStarts);
    std::vector<FocalPlace> result;
    for (const Maximum& one : maxima)
      result.push_back({sample_step() * signed_place(one.column), sample_step() * signed_place(one.row)});
    return result;
  }

 private:
  // Rows run along y and columns along x; the pattern is periodic.
  double signed_place(Eigen::Index k) const { return double(k <= n_ / 2 ? k : k - n_); }
  bool is_maximum(Eigen::Index row, Eigen::Index column) const {
    for (const int down : {-1, 0, 1})
      for (const int right : {-1, 0, 1})
        if (sample(row + down, column + right) > samples_(row, column)) return false;
    return true;
  }

  double sample(Eigen::Index row, Eigen::Index column) const {
    return samples_((row + n_) % n_, (column + n_) % n_);
  }
  double top_of_parabola(Eigen::Index row, Eigen::Index column) const {
    const double middle = sample(row, column);
    double top = middle;
    for (const auto& [down, right] : {std::pair{1, 0}, {0, 1}}) {
      const double before = sample(row - down, column - right), behind = sample(row + down, column + right);
      const double bend = 2 * middle - before - behind;
      if (bend > 0) top += (behind - before) * (behind - before) / (8 * bend);
    }
    return top;
  }

  // Transforms the samples to lags, multiplies by H, and transforms back.
  void scatter(const DiffractionGrid& grid) {
    ComplexMatrix lags = samples_.matrix().transpose().cast<Complex>();
    fourier_transform(n_, n_, lags.data());
    lags /= double(n_) * n_;
    for (Eigen::Index b = 0; b < n_; ++b)
      for (Eigen::Index a = 0; a < n_; ++a)
        lags(a, b) *= factor_at(grid, std::min(a, n_ - a), std::min(b, n_ - b));
    sums_ = {lags, Eigen::ArrayXd(n_), Eigen::ArrayXd(n_), 1};
    for (Eigen::Index k = 0; k < n_; ++k) sums_.row[k] = sums_.column[k] = signed_place(k);
    // The transfer function is Hermitian, so a forward transform of its conjugate is the inverse transform.
    ComplexMatrix pattern = lags.conjugate();
    fourier_transform(n_, n_, pattern.data());
    samples_ = pattern.transpose().real().array();
  }
  static double factor_at(const DiffractionGrid& grid, Eigen::Index column, Eigen::Index row) {
    if (row >= grid.transform.lag_rows() || column >= grid.lags.columns_within(int(row))) return 0;
    return grid.factor[grid.lags.length_of(int(row))[column]];
  }

  int n_;
  bool has_scatter_;
  PlacedMatrix sums_;
  Eigen::Array<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> samples_;
};

// Newton's method, or a step along the gradient where the second derivatives are not negative.
std::pair<FocalPlace, double> climb(const Landscape& light, const FocalPlace& start) {
  const double sample = light.sample_step();
  Eigen::Vector2d place(start.u, start.v);
  Hill here = light.at(place[0], place[1]);
  for (int k = 0; k < kMostSteps; ++k) {
    const double determinant = here.bend.determinant();
    Eigen::Vector2d step = here.slope;
    if (here.bend(0, 0) < 0 && determinant > 0) step = -here.bend.inverse() * here.slope;
    const double length = step.norm(), longest = 0.5 * sample;
    if (!(length > 0)) break;
    const bool newton = here.bend(0, 0) < 0 && determinant > 0;
    if (!newton || length > longest) step *= longest / length;
    Hill next = light.at(place[0] + step[0], place[1] + step[1]);
    while (next.value < here.value * (1 - kSameLight) && step.norm() > kStill * sample) {
      step *= 0.5;
      next = light.at(place[0] + step[0], place[1] + step[1]);
    }
    if (next.value < here.value * (1 - kSameLight)) break;
    place += step;
    here = next;
    if (step.norm() < kStill * sample) break;
  }
  return {{place[0], place[1]}, here.value};
}

}  // namespace

namespace internal {

FocalPlace highest_place(const DiffractionScene& scene, const DiffractionGrid& grid) {
  const Landscape light(scene, grid);
  FocalPlace best;
  double highest = 0;
  for (const FocalPlace& start : light.starts()) {
    const auto [place, value] = climb(light, start);
    if (value > highest) best = place, highest = value;
  }
  if (std::hypot(best.u, best.v) < kOnAxis * light.sample_step()) return {};
  return best;
}

Eigen::ArrayXd tilt_from(const DiffractionScene& scene, const FocalPlace& place) {
  const CartesianGrid& cells = scene.grid();
  Eigen::ArrayXd height(scene.points());
  for (Eigen::Index k = 0; k < height.size(); ++k)
    height[k] =
        -(place.u * double(cells.column[std::size_t(k)]) + place.v * double(cells.row[std::size_t(k)])) /
        scene.per_height()[k];
  return height;
}

double axis_ratio(const DiffractionScene& scene, const DiffractionPlane& plane) {
  const double to_period = 1 / scene.per_period(0);
  const MeanScatter* scatter = scene.problem().scatter.get();
  return (plane.otf().values().sum() + (scatter ? scatter->irradiance() * to_period * to_period : 0)) /
         scene.perfect_irradiance();
}

}  // namespace internal

DiffractionPeak diffraction_peak(const DiffractionProblem& problem, const Eigen::ArrayXd& height) {
  const DiffractionScene scene(problem, height, 1);
  const DiffractionGrid grid(scene);
  DiffractionBench bench(grid.transform);
  const auto on_axis = [&](const DiffractionScene& of) {
    bench.focused.dz = std::nan("");  // plane of another surface
    DiffractionPlane plane(of, grid, bench.buffers, bench.focused);
    plane.focus(0);
    return axis_ratio(of, plane);
  };
  const FocalPlace place = highest_place(scene, grid);
  const double per_radian = problem.wavelength * problem.focal_length / (2 * kPi);
  DiffractionPeak peak;
  peak.x = place.u * per_radian / problem.pupil.pitch_x;
  peak.y = place.v * per_radian / problem.pupil.pitch_y;
  peak.axis_ratio = peak.strehl = on_axis(scene);
  if (place.u != 0 || place.v != 0)
    peak.strehl = on_axis(DiffractionScene(problem, height + tilt_from(scene, place), 1));
  return peak;
}

}  // namespace aberfit
