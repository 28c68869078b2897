// Points are processed in chunks of 4096 (a thread's unit of work) and blocks of 256 (which fit the
// first-level cache). Each family of terms adds itself to the block:
// - Zernike, zernike_kernel.h: for each |m| a Clenshaw recurrence in tau = 4 rho^2 - 2 over the radial order.
//   Cosine and sine sums and their derivatives run together. Their factor (x + iy)^m is carried from one m
//   to the next. Value and gradient take 4.5 multiply-adds per term and point.
// - Fourier, fourier_kernel.h: a vectorised sine and cosine per mode and point.
// - Spherical, spherical_terms.h: a few even powers.
// The adjoint runs the same recurrences upwards and sums over the points of a block.
#include "pointwise_operator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "aberfit/core/parallel.h"
#include "spherical_terms.h"

namespace aberfit::internal {
namespace {

using Eigen::Index;

constexpr Index kChunkPoints = 4096;
static_assert(kChunkPoints % kBlockPoints == 0);

std::size_t chunks_of(Index points) { return std::size_t((points + kChunkPoints - 1) / kChunkPoints); }

/// Writes from[begin + i] / unit to the block, and zeros to the unused entries.
void gather(const Eigen::ArrayXd& from, double unit, Index begin, int used, double* to) {
  for (int i = 0; i < used; ++i) to[i] = from[begin + i] / unit;
  std::fill(to + used, to + kBlockPoints, 0.0);
}

/// Moves points outside the unit circle onto it.
void pull_to_rim(PointBlock* block) {
  for (int i = 0; i < block->used; ++i) {
    const double rho2 = block->x[i] * block->x[i] + block->y[i] * block->y[i];
    const double shrink = rho2 > 1 ? 1 / std::sqrt(rho2) : 1.0;
    block->x[i] *= shrink;
    block->y[i] *= shrink;
  }
}

/// Calls body(begin, used) for the blocks of a chunk.
template <typename Body>
void for_blocks(std::size_t chunk, Index points, const Body& body) {
  const Index begin = Index(chunk) * kChunkPoints, end = std::min(points, begin + kChunkPoints);
  for (Index at = begin; at < end; at += kBlockPoints) body(at, int(std::min<Index>(kBlockPoints, end - at)));
}

}  // namespace

PointwiseOperator::PointwiseOperator(const TermSet& terms, PointCoordinates points, Families families)
    : radius_(terms.radius),
      spherical_(terms.spherical),
      zernike_(zernike_rows(terms.zernike)),
      fourier_(fourier_rows(terms.fourier)),
      points_(std::move(points)),
      families_(families),
      set_(best_instruction_set()) {}

void PointwiseOperator::pack(const Eigen::VectorXd& coefficients, std::vector<double>* packed) const {
  packed->assign(packed_size(), 0.0);
  const std::size_t zernikes = zernike_.slot.size();
  for (std::size_t j = 0; j < zernikes; ++j)
    (*packed)[zernike_.slot[j]] += zernike_.scale[j] * coefficients[Index(j)];
  std::copy_n(coefficients.begin() + Index(zernikes), 2 * fourier_.modes() + Index(spherical_.size()),
              packed->begin() + std::ptrdiff_t(fourier_at()));
}

void PointwiseOperator::forward_block(const double* packed, Index begin, int used, bool add,
                                      SurfaceField* field) const {
  PointBlock block;
  block.used = used;
  for (double* sum : {block.height, block.slope_x, block.slope_y}) std::fill(sum, sum + kBlockPoints, 0.0);
  if (families_.zernike || families_.spherical) {
    points_.gather(nullptr, begin, used, radius_, &block);
    if (families_.spherical) spherical_forward(spherical_, packed + spherical_at(), &block);
    if (families_.zernike) {
      if (points_.hold_at_rim) pull_to_rim(&block);
      zernike_forward(set_, zernike_, packed, &block);
    }
    for (int i = 0; i < used; ++i) block.slope_x[i] /= radius_, block.slope_y[i] /= radius_;
  }
  if (families_.fourier) {
    points_.gather(nullptr, begin, used, 1.0, &block);
    fourier_forward(set_, fourier_, packed + fourier_at(), &block);
  }
  deliver(block.height, used, add, field->height.data() + begin);
  deliver(block.slope_x, used, add, field->slope_x.data() + begin);
  deliver(block.slope_y, used, add, field->slope_y.data() + begin);
}

void PointwiseOperator::adjoint_block(const std::uint32_t* rays, const SurfaceField& weights,
                                      Families families, Index begin, int used, std::vector<CacheLine>* lanes,
                                      double* packed) const {
  PointBlock block;
  block.used = used;
  gather(weights.height, 1.0, begin, used, block.height);
  const auto place = [&](double unit) {
    points_.gather(rays, begin, used, unit, &block);
    gather(weights.slope_x, unit, begin, used, block.slope_x);
    gather(weights.slope_y, unit, begin, used, block.slope_y);
  };
  if (families.fourier) {
    place(1.0);
    fourier_adjoint(set_, fourier_, block, packed + fourier_at());
  }
  if (families.zernike || families.spherical) {
    place(radius_);
    if (families.spherical) spherical_adjoint(spherical_, block, packed + spherical_at());
    if (families.zernike) {
      if (points_.hold_at_rim) pull_to_rim(&block);
      zernike_adjoint(set_, zernike_, block, lanes, packed);
    }
  }
}

void PointwiseOperator::forward(const Eigen::VectorXd& coefficients, int threads, bool add,
                                SurfaceField* field) const {
  const auto packed = packed_.take();
  pack(coefficients, &*packed);
  parallel_for(chunks_of(points_.size()), threads, [&](std::size_t chunk) {
    for_blocks(chunk, points_.size(),
               [&](Index begin, int used) { forward_block(packed->data(), begin, used, add, field); });
  });
}

void PointwiseOperator::adjoint(const SurfaceField& weights, int threads, Eigen::VectorXd* sums) const {
  adjoint(nullptr, weights, families_, threads, sums);
}

void PointwiseOperator::adjoint(const std::uint32_t* rays, const SurfaceField& weights, Families families,
                                int threads, Eigen::VectorXd* sums) const {
  const auto scratch = sums_.take();
  const auto add_chunk = [&](std::size_t chunk, double* packed) {
    const auto lanes = lanes_.take();
    for_blocks(chunk, weights.size(), [&](Index begin, int used) {
      adjoint_block(rays, weights, families, begin, used, &*lanes, packed);
    });
  };
  sum_chunks(chunks_of(weights.size()), packed_size(), threads, add_chunk, &*scratch);

  const double* total = scratch->total.data();
  const Index zernikes = Index(zernike_.slot.size()), fouriers = 2 * fourier_.modes();
  if (families.zernike)
    for (Index j = 0; j < zernikes; ++j)
      (*sums)[j] = zernike_.scale[std::size_t(j)] * total[zernike_.slot[std::size_t(j)]];
  if (families.fourier) std::copy_n(total + fourier_at(), fouriers, sums->begin() + zernikes);
  if (families.spherical)
    std::copy_n(total + spherical_at(), spherical_.size(), sums->begin() + zernikes + fouriers);
}

}  // namespace aberfit::internal
