#include "zernike_polar.h"

#include <algorithm>

#include "aberfit/core/parallel.h"

namespace aberfit::internal {

using Eigen::Index;

ZernikePolar::ZernikePolar(const TermSet& terms, const PolarRings& rings)
    : rows_(zernike_rows(terms.zernike)),
      x_(rings.rho * rings.turn.cos() / terms.radius),
      y_(rings.rho * rings.turn.sin() / terms.radius),
      spokes_(rings.spokes),
      slope_unit_(1.0 / terms.radius),
      transforms_(int(rings.spokes)),
      set_(best_instruction_set()) {
  const int spokes = int(spokes_);
  for (int m = 0; m <= rows_.m_max(); ++m) {
    const int f = m % spokes, mirror = (spokes - f) % spokes;
    const bool flip = f > mirror;
    // The down part of order m has the frequency 1 - m in the spectrum of the slopes.
    folds_.push_back(
        {flip ? mirror : f, (m + 1) % spokes, (1 + mirror) % spokes, flip, f == mirror ? 1.0 : 0.5});
  }
}

void ZernikePolar::prepare(Scratch* scratch) const {
  if (!scratch->memory.empty()) return;
  const std::size_t line = cache_lines(2 * std::size_t(spokes_) + 2);
  scratch->memory.resize(4 * line);
  const auto at = [&](std::size_t i) { return reinterpret_cast<Complex*>(scratch->memory[i * line].lane); };
  scratch->half_spectrum = at(0), scratch->spectrum = at(1), scratch->slopes = at(2);
  scratch->heights = scratch->memory[3 * line].lane;
  scratch->orders.resize(folds_.size());
}

RingBlock ZernikePolar::block_of(Index begin) const {
  RingBlock block{};
  const Index count = std::min<Index>(kBlockRings, x_.size() - begin);
  std::copy_n(x_.data() + begin, count, block.x);
  std::copy_n(y_.data() + begin, count, block.y);
  return block;
}

void ZernikePolar::forward_ring(int lane, Index ring, bool add, Scratch* scratch, SurfaceField* field) const {
  std::fill_n(scratch->half_spectrum, spokes_ / 2 + 1, Complex());
  std::fill_n(scratch->spectrum, spokes_, Complex());
  for (std::size_t m = 0; m < folds_.size(); ++m) {
    const Fold& fold = folds_[m];
    const RingOrder& order = scratch->orders[m];
    const double im = order.height_im[lane];
    scratch->half_spectrum[fold.height] +=
        fold.height_factor * Complex(order.height_re[lane], fold.height_conj ? -im : im);
    scratch->spectrum[fold.up] += Complex(order.up_re[lane], order.up_im[lane]);
    scratch->spectrum[fold.down] += Complex(order.down_re[lane], order.down_im[lane]);
  }
  transforms_.to_real(scratch->half_spectrum, scratch->heights);
  transforms_.backward(scratch->spectrum, scratch->slopes);

  const Index begin = ring * spokes_;
  const double* slopes = reinterpret_cast<const double*>(scratch->slopes);
  double *slope_x = field->slope_x.data() + begin, *slope_y = field->slope_y.data() + begin;
  deliver(scratch->heights, spokes_, add, field->height.data() + begin);
  if (add)
    for (Index j = 0; j < spokes_; ++j) slope_x[j] += slopes[2 * j], slope_y[j] += slopes[2 * j + 1];
  else
    for (Index j = 0; j < spokes_; ++j) slope_x[j] = slopes[2 * j], slope_y[j] = slopes[2 * j + 1];
}

void ZernikePolar::adjoint_ring(int lane, Index ring, const SurfaceField& weights, Scratch* scratch) const {
  const Index begin = ring * spokes_;
  const double *weight_x = weights.slope_x.data() + begin, *weight_y = weights.slope_y.data() + begin;
  std::copy_n(weights.height.data() + begin, spokes_, scratch->heights);
  for (Index j = 0; j < spokes_; ++j) scratch->slopes[j] = Complex(weight_x[j], weight_y[j]);
  transforms_.from_real(scratch->heights, scratch->half_spectrum);
  transforms_.forward(scratch->slopes, scratch->spectrum);

  for (std::size_t m = 0; m < folds_.size(); ++m) {
    const Fold& fold = folds_[m];
    RingOrder& order = scratch->orders[m];
    const Complex height = scratch->half_spectrum[fold.height];
    const Complex up = scratch->spectrum[fold.up], down = scratch->spectrum[fold.down];
    order.height_re[lane] = height.real();
    order.height_im[lane] = fold.height_conj ? -height.imag() : height.imag();
    order.up_re[lane] = up.real(), order.up_im[lane] = up.imag();
    order.down_re[lane] = down.real(), order.down_im[lane] = down.imag();
  }
}

void ZernikePolar::forward(const Eigen::VectorXd& coefficients, int threads, bool add,
                           SurfaceField* field) const {
  const auto packed = packed_.take();
  packed->assign(2 * rows_.rows(), 0.0);
  for (std::size_t j = 0; j < rows_.slot.size(); ++j)
    (*packed)[rows_.slot[j]] += rows_.scale[j] * coefficients[Index(j)];

  const Index rings = x_.size();
  parallel_for(std::size_t((rings + kBlockRings - 1) / kBlockRings), threads, [&](std::size_t block) {
    const auto scratch = scratch_.take();
    prepare(&*scratch);
    const Index begin = Index(block) * kBlockRings, end = std::min<Index>(rings, begin + kBlockRings);
    polar_forward(set_, rows_, packed->data(), slope_unit_, block_of(begin), scratch->orders.data());
    for (Index ring = begin; ring < end; ++ring) forward_ring(int(ring - begin), ring, add, &*scratch, field);
  });
}

void ZernikePolar::adjoint(const SurfaceField& weights, int threads, Eigen::VectorXd* sums) const {
  const auto partial = sums_.take();
  const Index rings = x_.size();
  const auto add_block = [&](std::size_t block, double* packed) {
    const auto scratch = scratch_.take();
    prepare(&*scratch);
    const Index begin = Index(block) * kBlockRings, end = std::min<Index>(rings, begin + kBlockRings);
    if (end - begin < kBlockRings)  // missing rings have no weight
      std::fill(scratch->orders.begin(), scratch->orders.end(), RingOrder{});
    for (Index ring = begin; ring < end; ++ring) adjoint_ring(int(ring - begin), ring, weights, &*scratch);
    polar_adjoint(set_, rows_, slope_unit_, block_of(begin), scratch->orders.data(), &scratch->lanes, packed);
  };
  sum_chunks(std::size_t((rings + kBlockRings - 1) / kBlockRings), 2 * rows_.rows(), threads, add_block,
             &*partial);
  for (std::size_t j = 0; j < rows_.slot.size(); ++j)
    (*sums)[Index(j)] = rows_.scale[j] * partial->total[rows_.slot[j]];
}

}  // namespace aberfit::internal
