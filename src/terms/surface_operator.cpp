// Method. Points are taken in chunks of 4096 (the unit of work of a thread) and blocks of 256 (what fits the
// first-level cache), and each family of terms adds itself to the block:
// - Zernike, zernike_kernel.h: per |m| a Clenshaw recurrence in tau = 4 rho^2 - 2 over the radial order,
//   cosine and sine sums and their derivatives side by side, times the harmonic (x + iy)^m carried from one m
//   to the next; 4.5 multiply-adds per term and point, value and gradient.
// - Fourier, fourier_kernel.h: a vectorised sine and cosine per mode and point.
// - Spherical, spherical_terms.h: a handful of even powers.
// The adjoint runs the same recurrences upwards and sums over the points of a block; each chunk gives one
// partial vector, and these are added in chunk order, so neither the thread count nor the schedule changes a
// bit.
//
// Error of one Zernike mode against its factorial sum in 200 digits, relative to its largest value (gradient)
// over the disc (tests/terms/zernike_test.cpp): 4e-14 to n = 40, 2.5e-13 at n = 100, 2.2e-12 at n = 300. That
// is at the rim, where the rounding of tau costs about n^2 eps / 16; between 0.1 and 0.9 of the radius it is
// below 7e-15.
//
// Speed, 1e9 term-points (Fourier: mode-points, a mode being two terms) per second, value and gradient, one
// thread on a Xeon server core (AVX-512, two multiply-add units), release build, 65536 points (8192 at n =
// 300), median of at least 15 runs, quartiles within 5 %; beside it the same core with the AVX2 and the SSE2
// kernels:
//                     AVX-512            AVX2               SSE2
//                     forward  adjoint   forward  adjoint   forward  adjoint
//     n =   8,    45     4.5      3.5       3.0      2.3       1.4      1.2
//     n =  20,   231     8.2      6.8       4.8      3.9       1.7      1.7
//     n =  40,   861    10.4      9.1       5.7      4.8       1.9      1.9
//     n = 300, 45451    12.7     11.4       5.3      4.7       2.0      2.1
//     400 modes          1.7      1.6       1.0      1.0       0.3      0.3
#include "aberfit/terms/surface_operator.h"

#include <fmt/core.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "aberfit/core/parallel.h"
#include "fourier_kernel.h"
#include "point_block.h"
#include "spherical_terms.h"
#include "zernike_kernel.h"

namespace aberfit {
namespace {

using Eigen::Index;

constexpr Index kChunkPoints = 4096;
static_assert(kChunkPoints % kBlockPoints == 0);

/// Chunks whose partial vectors are held at a time: bounds the memory of an adjoint over very many rays.
constexpr Index kWaveChunks = 128;

Index chunks_of(Index points) { return (points + kChunkPoints - 1) / kChunkPoints; }

void check(const TermSet& terms, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y) {
  if (x.size() != y.size())
    throw std::invalid_argument(
        fmt::format("SurfaceOperator: {} x but {} y coordinates", x.size(), y.size()));
  const bool on_disc = !terms.zernike.empty() || !terms.spherical.empty();
  if (on_disc && !(terms.radius > 0 && std::isfinite(terms.radius)))
    throw std::invalid_argument(fmt::format("SurfaceOperator: radius {} m, must be positive", terms.radius));
  for (const int power : terms.spherical)
    if (power < 2 || power % 2 != 0)
      throw std::invalid_argument(
          fmt::format("SurfaceOperator: spherical power {}, must be even and positive", power));
}

/// Puts from[point_of(begin + i)] / unit into the block and zeros into the places left over.
template <typename PointOf>
void gather(const Eigen::ArrayXd& from, double unit, Index begin, int used, const PointOf& point_of,
            double* to) {
  for (int i = 0; i < used; ++i) to[i] = from[point_of(begin + i)] / unit;
  std::fill(to + used, to + kBlockPoints, 0.0);
}

Index same(Index i) { return i; }

}  // namespace

std::string to_string(ZernikeMethod method) {
  switch (method) {
    case ZernikeMethod::kFused:
      return "fused";
    case ZernikeMethod::kPolar:
      return "polar";
    case ZernikeMethod::kDense:
      break;
  }
  return "dense";
}

std::string to_string(FourierMethod method) {
  switch (method) {
    case FourierMethod::kPhaseSums:
      return "phase-sums";
    case FourierMethod::kGrid:
      return "grid";
    case FourierMethod::kDense:
      break;
  }
  return "dense";
}

struct SurfaceOperator::Plan {
  TermSet terms;
  Eigen::ArrayXd x, y;  // [m]
  int threads;
  ZernikeRows zernike;
  FourierRows fourier;
  InstructionSet set;
  OperatorChoice choice;

  // A packed vector holds the coefficients as the kernels want them: Zernike rows (cosine and sine, scaled to
  // the monic polynomials), then A and B per Fourier mode, then the spherical terms.
  std::size_t fourier_at() const { return 2 * zernike.rows(); }
  std::size_t spherical_at() const { return fourier_at() + 2 * terms.fourier.size(); }
  std::size_t packed_size() const { return spherical_at() + terms.spherical.size(); }

  std::vector<double> pack(const Eigen::VectorXd& coefficients) const;
  Eigen::VectorXd pack_transpose(const std::vector<double>& packed) const;
  void forward(const double* packed, Index begin, int used, SurfaceField* field) const;
  template <typename PointOf>
  void adjoint(const SurfaceField& weights, Index begin, int used, const PointOf& point_of,
               double* packed) const;
  template <typename PointOf>
  Eigen::VectorXd adjoint_sum(const SurfaceField& weights, const PointOf& point_of) const;

  bool on_disc() const { return !terms.zernike.empty() || !terms.spherical.empty(); }
};

std::vector<double> SurfaceOperator::Plan::pack(const Eigen::VectorXd& coefficients) const {
  std::vector<double> packed(packed_size(), 0.0);
  for (std::size_t j = 0; j < terms.zernike.size(); ++j)
    packed[zernike.slot[j]] += zernike.scale[j] * coefficients[Index(j)];
  std::copy(coefficients.begin() + terms.fourier_begin(), coefficients.end(),
            packed.begin() + std::ptrdiff_t(fourier_at()));
  return packed;
}

Eigen::VectorXd SurfaceOperator::Plan::pack_transpose(const std::vector<double>& packed) const {
  Eigen::VectorXd sums(terms.size());
  for (std::size_t j = 0; j < terms.zernike.size(); ++j)
    sums[Index(j)] = zernike.scale[j] * packed[zernike.slot[j]];
  std::copy(packed.begin() + std::ptrdiff_t(fourier_at()), packed.end(),
            sums.begin() + terms.fourier_begin());
  return sums;
}

void SurfaceOperator::Plan::forward(const double* packed, Index begin, int used, SurfaceField* field) const {
  PointBlock block;
  block.used = used;
  for (double* sum : {block.height, block.slope_x, block.slope_y}) std::fill(sum, sum + kBlockPoints, 0.0);
  if (on_disc()) {
    gather(x, terms.radius, begin, used, same, block.x);
    gather(y, terms.radius, begin, used, same, block.y);
    if (!terms.zernike.empty()) zernike_forward(set, zernike, packed, &block);
    if (!terms.spherical.empty()) spherical_forward(terms.spherical, packed + spherical_at(), &block);
    for (int i = 0; i < used; ++i) block.slope_x[i] /= terms.radius, block.slope_y[i] /= terms.radius;
  }
  if (!terms.fourier.empty()) {
    gather(x, 1.0, begin, used, same, block.x);
    gather(y, 1.0, begin, used, same, block.y);
    fourier_forward(set, fourier, packed + fourier_at(), &block);
  }
  std::copy_n(block.height, used, field->height.data() + begin);
  std::copy_n(block.slope_x, used, field->slope_x.data() + begin);
  std::copy_n(block.slope_y, used, field->slope_y.data() + begin);
}

template <typename PointOf>
void SurfaceOperator::Plan::adjoint(const SurfaceField& weights, Index begin, int used,
                                    const PointOf& point_of, double* packed) const {
  PointBlock block;
  block.used = used;
  gather(weights.height, 1.0, begin, used, same, block.height);
  const auto place = [&](double unit) {
    gather(x, unit, begin, used, point_of, block.x);
    gather(y, unit, begin, used, point_of, block.y);
    gather(weights.slope_x, unit, begin, used, same, block.slope_x);
    gather(weights.slope_y, unit, begin, used, same, block.slope_y);
  };
  if (!terms.fourier.empty()) {
    place(1.0);
    fourier_adjoint(set, fourier, block, packed + fourier_at());
  }
  if (on_disc()) {
    place(terms.radius);
    if (!terms.zernike.empty()) zernike_adjoint(set, zernike, block, packed);
    if (!terms.spherical.empty()) spherical_adjoint(terms.spherical, block, packed + spherical_at());
  }
}

template <typename PointOf>
Eigen::VectorXd SurfaceOperator::Plan::adjoint_sum(const SurfaceField& weights,
                                                   const PointOf& point_of) const {
  const Index points = weights.size(), chunks = chunks_of(points);
  std::vector<double> total(packed_size(), 0.0);
  std::vector<std::vector<double>> partial(std::size_t(std::min(chunks, kWaveChunks)));
  for (Index wave = 0; wave < chunks; wave += kWaveChunks) {
    const std::size_t count = std::size_t(std::min(kWaveChunks, chunks - wave));
    parallel_for(count, threads, [&](std::size_t i) {
      partial[i].assign(packed_size(), 0.0);
      const Index begin = (wave + Index(i)) * kChunkPoints, end = std::min(points, begin + kChunkPoints);
      for (Index at = begin; at < end; at += kBlockPoints)
        adjoint(weights, at, int(std::min<Index>(kBlockPoints, end - at)), point_of, partial[i].data());
    });
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < total.size(); ++j) total[j] += partial[i][j];
  }
  return pack_transpose(total);
}

SurfaceOperator::SurfaceOperator(TermSet terms, Eigen::ArrayXd x, Eigen::ArrayXd y, int threads) {
  check(terms, x, y);
  ZernikeRows zernike = zernike_rows(terms.zernike);
  FourierRows fourier = fourier_rows(terms.fourier);
  OperatorChoice choice;
  if (!terms.zernike.empty()) choice.zernike = ZernikeMethod::kFused;
  if (!terms.fourier.empty()) choice.fourier = FourierMethod::kPhaseSums;
  choice.reason = "scattered points";
  plan_ = std::make_unique<const Plan>(Plan{std::move(terms), std::move(x), std::move(y), threads,
                                            std::move(zernike), std::move(fourier), best_instruction_set(),
                                            std::move(choice)});
}
SurfaceOperator::SurfaceOperator(TermSet terms, const PupilSample& pupil, const OperatorOptions& options)
    : SurfaceOperator(std::move(terms), pupil.x, pupil.y, options.threads) {}
SurfaceOperator::~SurfaceOperator() = default;
SurfaceOperator::SurfaceOperator(SurfaceOperator&&) noexcept = default;
SurfaceOperator& SurfaceOperator::operator=(SurfaceOperator&&) noexcept = default;

const TermSet& SurfaceOperator::terms() const { return plan_->terms; }
Index SurfaceOperator::points() const { return plan_->x.size(); }
const OperatorChoice& SurfaceOperator::choice() const { return plan_->choice; }

void SurfaceOperator::apply(const Eigen::VectorXd& coefficients, SurfaceField* field) const {
  assert(coefficients.size() == terms().size());
  const std::vector<double> packed = plan_->pack(coefficients);
  field->resize(points());
  parallel_for(std::size_t(chunks_of(points())), plan_->threads, [&](std::size_t chunk) {
    const Index begin = Index(chunk) * kChunkPoints, end = std::min(points(), begin + kChunkPoints);
    for (Index at = begin; at < end; at += kBlockPoints)
      plan_->forward(packed.data(), at, int(std::min<Index>(kBlockPoints, end - at)), field);
  });
}

Eigen::VectorXd SurfaceOperator::apply_transpose(const SurfaceField& weights) const {
  assert(weights.size() == points());
  return plan_->adjoint_sum(weights, same);
}

Eigen::VectorXd SurfaceOperator::apply_transpose(std::span<const std::uint32_t> rays,
                                                 const SurfaceField& weights) const {
  assert(weights.size() == Index(rays.size()));
  return plan_->adjoint_sum(weights, [rays](Index i) { return Index(rays[std::size_t(i)]); });
}

}  // namespace aberfit
