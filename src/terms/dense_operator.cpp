#include "dense_operator.h"

#include <algorithm>

#include "aberfit/core/parallel.h"
#include "pointwise_operator.h"

namespace aberfit::internal {
namespace {

using Eigen::Index;

constexpr Index kChunkBlocks = 64;  // unit of work of a thread: 1024 points

Index blocks_of(Index points) { return (points + kDensePoints - 1) / kDensePoints; }
std::size_t dense_chunks_of(Index points) {
  return std::size_t((blocks_of(points) + kChunkBlocks - 1) / kChunkBlocks);
}

/// Calls body(block, first point, points) for the blocks of a chunk.
template <typename Body>
void for_dense_blocks(std::size_t chunk, Index points, const Body& body) {
  const Index begin = Index(chunk) * kChunkBlocks, end = std::min(blocks_of(points), begin + kChunkBlocks);
  for (Index b = begin; b < end; ++b)
    body(b, b * kDensePoints, std::min<Index>(kDensePoints, points - b * kDensePoints));
}

}  // namespace

DenseOperator::DenseOperator(const TermSet& terms, bool fourier, const PointCoordinates& points, int threads)
    : points_(points.size()),
      begin_(fourier ? terms.fourier_begin() : 0),
      terms_(int(fourier ? 2 * terms.fourier.size() : terms.zernike.size())),
      basis_(cache_lines(std::size_t(blocks_of(points_)) * std::size_t(terms_) * kDenseValues)),
      set_(best_instruction_set()) {
  parallel_for(fourier ? terms.fourier.size() : terms.zernike.size(), threads, [&](std::size_t mode) {
    TermSet one;
    one.radius = terms.radius;
    if (fourier)
      one.fourier = {terms.fourier[mode]};
    else
      one.zernike = {terms.zernike[mode]};
    const PointwiseOperator column(one, points, {!fourier, fourier, false});
    SurfaceField field;
    field.resize(points_);
    for (Index j = 0; j < one.size(); ++j) {
      column.forward(Eigen::VectorXd::Unit(one.size(), j), 1, false, &field);
      fill(int(Index(mode) * one.size() + j), field);
    }
  });
}

const double* DenseOperator::basis_of(Index block) const {
  return basis_.data()->lane + std::size_t(block) * std::size_t(terms_) * kDenseValues;
}

void DenseOperator::fill(int term, const SurfaceField& field) {
  for (std::size_t chunk = 0; chunk < dense_chunks_of(points_); ++chunk)
    for_dense_blocks(chunk, points_, [&](Index block, Index at, Index used) {
      double* to =
          basis_.data()->lane + (std::size_t(block) * std::size_t(terms_) + std::size_t(term)) * kDenseValues;
      std::copy_n(field.height.data() + at, used, to);
      std::copy_n(field.slope_x.data() + at, used, to + kDensePoints);
      std::copy_n(field.slope_y.data() + at, used, to + 2 * kDensePoints);
    });
}

void DenseOperator::forward(const Eigen::VectorXd& coefficients, int threads, bool add,
                            SurfaceField* field) const {
  parallel_for(dense_chunks_of(points_), threads, [&](std::size_t chunk) {
    for_dense_blocks(chunk, points_, [&](Index block, Index at, Index used) {
      alignas(64) double values[kDenseValues];
      dense_forward(set_, terms_, basis_of(block), coefficients.data() + begin_, values);
      deliver(values, used, add, field->height.data() + at);
      deliver(values + kDensePoints, used, add, field->slope_x.data() + at);
      deliver(values + 2 * kDensePoints, used, add, field->slope_y.data() + at);
    });
  });
}

void DenseOperator::adjoint(const SurfaceField& weights, int threads, Eigen::VectorXd* sums) const {
  const auto partial = sums_.take();
  const auto add_chunk = [&](std::size_t chunk, double* lanes) {
    for_dense_blocks(chunk, points_, [&](Index block, Index at, Index used) {
      alignas(64) double values[kDenseValues] = {};
      std::copy_n(weights.height.data() + at, used, values);
      std::copy_n(weights.slope_x.data() + at, used, values + kDensePoints);
      std::copy_n(weights.slope_y.data() + at, used, values + 2 * kDensePoints);
      dense_adjoint(set_, terms_, basis_of(block), values, lanes);
    });
  };
  sum_chunks(dense_chunks_of(points_), 8 * std::size_t(terms_), threads, add_chunk, &*partial);
  for (Index t = 0; t < terms_; ++t) {
    const double* lane = partial->total.data() + 8 * t;
    (*sums)[begin_ + t] =
        ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
  }
}

}  // namespace aberfit::internal
