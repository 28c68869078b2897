// We use the Kaiser-Bessel kernel I0(b sqrt(1 - z^2))/I0(b) over 12 cells. Its transform has the closed form
// sinh(sqrt(b^2 - u^2))/sqrt(b^2 - u^2), u = pi 12 xi (Jackson et al. 1991; Barnett, Magland and af
// Klinteberg 2019). With b = 12 pi (1 - 1/4) and a grid twice as fine as the waves need, aliasing is exp(-12
// pi sqrt(1/2)) = 3e-12 of the largest value. Between two cells the kernel is twelve polynomials, one per
// tap. Slopes have separate transforms of the coefficients times 2 pi f. The real and the imaginary part
// carry one real field each.
#include "fourier_lattice.h"

#include <algorithm>
#include <array>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "aberfit/core/constants.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/smooth_number.h"

namespace aberfit::internal {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;

constexpr double kBeta = 0.75 * kPi * kLatticeTaps;
constexpr int kChunk = 512;        // points whose values are gathered together
constexpr int kGridsTogether = 4;  // grids that share one kernel evaluation

double kernel(double z) {
  const double t = z / (0.5 * kLatticeTaps), inside = std::max(0.0, 1 - t * t);
  return boost::math::cyl_bessel_i(0, kBeta * std::sqrt(inside)) / boost::math::cyl_bessel_i(0, kBeta);
}

double kernel_transform(double cycles_per_cell) {
  const double u = kPi * kLatticeTaps * cycles_per_cell, root = std::sqrt(kBeta * kBeta - u * u);
  return kLatticeTaps * std::sinh(root) / root / boost::math::cyl_bessel_i(0, kBeta);
}

// Power coefficients of the polynomial through the values at Chebyshev points, by its Chebyshev series. Both
// steps are well conditioned on -1..1.
std::array<double, kLatticeDegree + 1> polynomial(double first) {
  constexpr int n = kLatticeDegree + 1;
  std::array<double, n> value, powers{};
  for (int i = 0; i < n; ++i)
    value[std::size_t(i)] = kernel(first + 0.5 * (1 + std::cos(kPi * (i + 0.5) / n)));
  std::array<double, n> before{}, now{};  // power coefficients of T_(k-1), T_k
  before[1] = 1, now[0] = 1;              // T_-1 = T_1
  for (int k = 0; k < n; ++k) {
    double series = 0;
    for (int i = 0; i < n; ++i) series += value[std::size_t(i)] * std::cos(kPi * k * (i + 0.5) / n);
    for (int i = 0; i < n; ++i)
      powers[std::size_t(i)] += (k == 0 ? 1.0 : 2.0) / n * series * now[std::size_t(i)];
    std::array<double, n> next{};
    for (int i = 0; i < n; ++i)
      next[std::size_t(i)] = (i > 0 ? 2 * now[std::size_t(i - 1)] : 0.0) - before[std::size_t(i)];
    before = now, now = next;
  }
  return powers;
}

const LatticeTable& table() {
  static const LatticeTable made = [] {
    LatticeTable t{};
    for (int tap = 0; tap < kLatticeTaps; ++tap) {
      const auto powers = polynomial(tap - 0.5 * kLatticeTaps);
      for (int d = 0; d <= kLatticeDegree; ++d)
        t.x[d][2 * tap] = t.x[d][2 * tap + 1] = t.y[d][tap] = powers[std::size_t(kLatticeDegree - d)];
    }
    return t;
  }();
  return made;
}

}  // namespace

FourierLattice::FourierLattice(const TermSet& terms, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y)
    : begin_(terms.fourier_begin()), set_(best_instruction_set()) {
  const double pitch = terms.fourier_pitch;
  const auto number = [pitch](double f) {
    const double k = f / pitch;
    if (!(std::abs(k - std::round(k)) <= 1e-9 * std::max(1.0, std::abs(k))) || std::abs(k) > 1e6)
      throw std::invalid_argument("SurfaceOperator: a Fourier mode is not a point of the lattice");
    return int(std::lround(k));
  };
  int most = 0;
  for (const FourierMode& mode : terms.fourier)
    most = std::max({most, std::abs(number(mode.fx)), std::abs(number(mode.fy))});
  side_ = int(smooth_from(2 * (2 * most + 1) + 2));
  std::vector<double> scale(std::size_t(most) + 1);
  for (int k = 0; k <= most; ++k) scale[std::size_t(k)] = 1 / kernel_transform(double(k) / side_);
  const auto place = [this](int kx, int ky) {
    return std::uint32_t((ky + side_) % side_) * std::uint32_t(side_) + std::uint32_t((kx + side_) % side_);
  };
  modes_.reserve(terms.fourier.size());
  for (const FourierMode& mode : terms.fourier) {
    const int kx = number(mode.fx), ky = number(mode.fy);
    modes_.push_back({place(kx, ky), place(-kx, -ky),
                      scale[std::size_t(std::abs(kx))] * scale[std::size_t(std::abs(ky))], kTwoPi * mode.fx,
                      kTwoPi * mode.fy});
  }
  places_.resize(std::size_t(x.size()));
  // The first tap, and the distance of the point from the position of that tap, -1..1 across a grid cell.
  const auto locate = [&](double position, double* s) {
    double u = position * pitch;
    u = side_ * (u - std::floor(u));
    const double first = std::ceil(u - 0.5 * kLatticeTaps);
    *s = 2 * (first - (u - 0.5 * kLatticeTaps)) - 1;
    return long(first) + kLatticeTaps / 2;
  };
  for (std::size_t p = 0; p < places_.size(); ++p) {
    LatticePlace& at = places_[p];
    at.first = locate(x[Index(p)], &at.x);
    at.first += locate(y[Index(p)], &at.y) * (side_ + kLatticeTaps);
  }
  transform_ = std::make_unique<const FourierTransform>(side_, side_);
}

void FourierLattice::to_margined(const Complex* spectrum, double* grid) const {
  const int half = kLatticeTaps / 2, wide = side_ + kLatticeTaps;
  auto* to = reinterpret_cast<Complex*>(grid);
  for (int j = 0; j < wide; ++j, to += wide) {
    const Complex* row = spectrum + std::size_t((j - half + side_) % side_) * std::size_t(side_);
    std::copy_n(row + side_ - half, half, to);
    std::copy_n(row, side_, to + half);
    std::copy_n(row, half, to + half + side_);
  }
}

void FourierLattice::from_margined(const double* grid, Complex* spectrum) const {
  const int half = kLatticeTaps / 2, wide = side_ + kLatticeTaps;
  std::fill_n(spectrum, std::size_t(side_) * std::size_t(side_), Complex{});
  const auto* from = reinterpret_cast<const Complex*>(grid);
  for (int j = 0; j < wide; ++j, from += wide) {
    Complex* row = spectrum + std::size_t((j - half + side_) % side_) * std::size_t(side_);
    for (int i = 0; i < half; ++i) row[side_ - half + i] += from[i];
    for (int i = 0; i < side_; ++i) row[i] += from[half + i];
    for (int i = 0; i < half; ++i) row[i] += from[half + side_ + i];
  }
}

void FourierLattice::forward(const Eigen::VectorXd& coefficients, int threads, bool add,
                             SurfaceField* field) const {
  const auto scratch = scratch_.take();
  const std::size_t lines = cache_lines(2 * margined()), cells = std::size_t(side_) * std::size_t(side_);
  scratch->grid.resize(2 * lines);
  scratch->spectrum.resize(2 * cells);
  double* const grid[2] = {scratch->grid[0].lane, scratch->grid[lines].lane};
  parallel_for(2, threads, [&](std::size_t g) {
    Complex* const spectrum = scratch->spectrum.data() + g * cells;
    std::fill_n(spectrum, cells, Complex{});
    for (std::size_t k = 0; k < modes_.size(); ++k) {
      const Mode& mode = modes_[k];
      const double a = 0.5 * mode.scale * coefficients[begin_ + 2 * Index(k)],
                   b = 0.5 * mode.scale * coefficients[begin_ + 2 * Index(k) + 1];
      const double along = g == 0 ? mode.turn_x : mode.turn_y;
      const Complex wave(a, b), slope(along * b, -along * a);
      const Complex i(0, 1);
      spectrum[mode.place] = g == 0 ? wave + i * slope : slope;
      spectrum[mode.opposite] = g == 0 ? std::conj(wave) + i * std::conj(slope) : std::conj(slope);
    }
    (*transform_)(spectrum);
    to_margined(spectrum, grid[g]);
  });
  const Index points = Index(places_.size());
  parallel_for(std::size_t((points + kChunk - 1) / kChunk), threads, [&](std::size_t chunk) {
    const Index begin = Index(chunk) * kChunk, used = std::min<Index>(kChunk, points - begin);
    double values[4 * kChunk], line[kChunk];
    lattice_gather(set_, table(), int(used), places_.data() + begin, 2, grid, side_ + kLatticeTaps, values);
    const auto give = [&](Index from, double* to) {
      for (Index p = 0; p < used; ++p) line[p] = values[from + 2 * p];
      deliver(line, used, add, to + begin);
    };
    give(0, field->height.data());
    give(1, field->slope_x.data());
    give(2 * used, field->slope_y.data());
  });
}

/// Sums over all points of value(p, g) times the kernel. Grid g's transform starts at g side^2 of the
/// spectrum.
template <typename Value>
void FourierLattice::spread_all(int grids, const Value& value, Scratch* scratch) const {
  const std::size_t lines = cache_lines(2 * margined()), cells = std::size_t(side_) * std::size_t(side_);
  scratch->grid.assign(std::size_t(grids) * lines, CacheLine{});
  scratch->spectrum.resize(std::size_t(grids) * cells);
  scratch->values.resize(2 * std::size_t(grids) * kChunk);
  double* grid[kGridsTogether];
  for (int g = 0; g < grids; ++g) grid[g] = scratch->grid[std::size_t(g) * lines].lane;
  const Index points = Index(places_.size());
  for (Index begin = 0; begin < points; begin += kChunk) {
    const Index used = std::min<Index>(kChunk, points - begin);
    for (int g = 0; g < grids; ++g)
      for (Index p = 0; p < used; ++p) {
        const Complex v = value(begin + p, g);
        double* to = scratch->values.data() + 2 * (Index(g) * used + p);
        to[0] = v.real(), to[1] = v.imag();
      }
    lattice_spread(set_, table(), int(used), places_.data() + begin, grids, scratch->values.data(),
                   side_ + kLatticeTaps, grid);
  }
  for (int g = 0; g < grids; ++g) {
    Complex* const spectrum = scratch->spectrum.data() + std::size_t(g) * cells;
    from_margined(grid[g], spectrum);
    (*transform_)(spectrum);
  }
}

namespace {

// Transforms of the two real fields in one complex field.
struct Pair {
  Complex real, imaginary;
};
Pair parts(Complex at, Complex opposite) {
  const Complex sum = at + std::conj(opposite), difference = at - std::conj(opposite);
  return {0.5 * sum, Complex(0.5 * difference.imag(), -0.5 * difference.real())};
}

}  // namespace

void FourierLattice::adjoint(const SurfaceField& weights, int threads, Eigen::VectorXd* sums) const {
  std::array<ScratchPool<Scratch>::Lease, 2> scratch{scratch_.take(), scratch_.take()};
  parallel_for(2, threads, [&](std::size_t g) {
    if (g == 0)
      spread_all(
          1, [&](Index p, int) { return Complex(weights.height[p], weights.slope_x[p]); }, &*scratch[0]);
    else
      spread_all(
          1, [&](Index p, int) { return Complex(weights.slope_y[p], 0); }, &*scratch[1]);
  });
  const Complex *both = scratch[0]->spectrum.data(), *y = scratch[1]->spectrum.data();
  for (std::size_t k = 0; k < modes_.size(); ++k) {
    const Mode& mode = modes_[k];
    const Pair pair = parts(both[mode.place], both[mode.opposite]);
    const Complex slope = mode.turn_x * pair.imaginary + mode.turn_y * y[mode.place];
    (*sums)[begin_ + 2 * Index(k)] = mode.scale * (pair.real.real() + slope.imag());
    (*sums)[begin_ + 2 * Index(k) + 1] = mode.scale * (slope.real() - pair.real.imag());
  }
}

void FourierLattice::heights(std::span<const Eigen::ArrayXd> weights, int threads, Index begin,
                             Eigen::MatrixXd* sums) const {
  constexpr std::size_t kBatch = 2 * kGridsTogether;
  const std::size_t cells = std::size_t(side_) * std::size_t(side_);
  parallel_for((weights.size() + kBatch - 1) / kBatch, threads, [&](std::size_t batch) {
    const auto of = weights.subspan(kBatch * batch, std::min(kBatch, weights.size() - kBatch * batch));
    const auto scratch = scratch_.take();
    const auto value = [&](Index p, int g) {
      const std::size_t first = 2 * std::size_t(g);
      return Complex(of[first][p], first + 1 < of.size() ? of[first + 1][p] : 0.0);
    };
    spread_all(int(of.size() + 1) / 2, value, &*scratch);
    for (std::size_t j = 0; j < of.size(); ++j) {
      const Complex* spectrum = scratch->spectrum.data() + j / 2 * cells;
      double* to = sums->data() + Index(kBatch * batch + j) * sums->rows() + begin;
      for (std::size_t k = 0; k < modes_.size(); ++k) {
        const Mode& mode = modes_[k];
        const Pair pair = parts(spectrum[mode.place], spectrum[mode.opposite]);
        const Complex wave = j % 2 == 0 ? pair.real : pair.imaginary;
        to[2 * k] = mode.scale * wave.real();
        to[2 * k + 1] = -mode.scale * wave.imag();
      }
    }
  });
}

// One grid cell of a transform costs about fifty times as much as one wave at one point.
Index FourierLattice::enough_rays() const {
  return Index(50.0 * side_ * side_ / double(std::max<std::size_t>(1, modes_.size())));
}

}  // namespace aberfit::internal
