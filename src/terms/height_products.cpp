#include "height_products.h"

#include <algorithm>
#include <cmath>

#include "height_kernel.h"

namespace aberfit::internal {
namespace {

using Eigen::Index;

constexpr std::size_t kTogether = 8;
constexpr Index kChunkOrbits = 6 * kBlockOrbits;  // a thread's unit of work

// The points' grid, if it is symmetric under reflections at both axes; else null.
const CartesianGrid* mirrored_grid(const PupilSample& pupil) {
  const auto* grid = std::get_if<CartesianGrid>(&pupil.structure);
  if (const auto* directions = std::get_if<DirectionGrid>(&pupil.structure)) grid = &directions->cells;
  if (!pupil.segment.empty() || !grid || grid->x.size() == 0 || grid->y.size() == 0) return nullptr;
  const auto mirrored = [](const Eigen::ArrayXd& a) {
    return (a + a.reverse()).abs().maxCoeff() <= 1e-13 * a.abs().maxCoeff();
  };
  return mirrored(grid->x) && mirrored(grid->y) ? grid : nullptr;
}

std::size_t cache_aligned(std::size_t doubles) { return 8 * cache_lines(doubles); }

}  // namespace

HeightProducts::HeightProducts(const TermSet& terms, const PupilSample& pupil, bool hold_at_rim)
    : radius_(terms.radius),
      zernike_(zernike_rows(terms.zernike)),
      fourier_(fourier_rows(terms.fourier)),
      spherical_(terms.spherical),
      hold_at_rim_(hold_at_rim),
      set_(best_instruction_set()) {
  const CartesianGrid* grid = mirrored_grid(pupil);
  folded_ = grid != nullptr;
  if (!grid) {
    x_ = pupil.x;
    y_ = pupil.y;
    return;
  }
  const auto columns = std::size_t(grid->x.size()), rows = std::size_t(grid->y.size());
  const std::size_t right = columns / 2, upper = rows / 2;  // first index with x, y >= 0
  std::vector<std::int32_t> orbit((columns - right) * (rows - upper), -1);
  std::vector<double> x, y;
  for (Index k = 0; k < pupil.size(); ++k) {
    const std::size_t column = grid->column[std::size_t(k)], row = grid->row[std::size_t(k)];
    const bool left = column < right, lower = row < upper;
    const std::size_t i = (left ? columns - 1 - column : column) - right,
                      j = (lower ? rows - 1 - row : row) - upper;
    std::int32_t& at = orbit[j * (columns - right) + i];
    if (at < 0) {
      at = std::int32_t(x.size());
      x.push_back(std::abs(pupil.x[k]));
      y.push_back(std::abs(pupil.y[k]));
      members_.insert(members_.end(), 4, -1);
    }
    members_[4 * std::size_t(at) + (left ? 1 : 0) + (lower ? 2 : 0)] = std::int32_t(k);
  }
  x_ = Eigen::Map<Eigen::ArrayXd>(x.data(), Index(x.size()));
  y_ = Eigen::Map<Eigen::ArrayXd>(y.data(), Index(y.size()));
}

// Writes whole cache lines of weights. Rows of `to` are so far apart that a line written by single weights
// would leave the cache in between.
void HeightProducts::fold(std::span<const Eigen::ArrayXd> weights, Index begin, int used, int columns,
                          std::size_t of_class, double* to) const {
  const std::size_t count = weights.size();
  if (!folded_) {
    for (int p = 0; p < used; ++p, to += columns)
      for (std::size_t k = 0; k < count; ++k) to[k] = weights[k][begin + p];
    return;
  }
  const std::int32_t* member = members_.data() + 4 * std::size_t(begin);
  for (int p = 0; p < used; ++p, member += 4, to += columns) {
    double at[4][kTogether];
    for (int q = 0; q < 4; ++q)
      for (std::size_t k = 0; k < kTogether; ++k)
        at[q][k] = member[q] >= 0 && k < count ? weights[k].data()[member[q]] : 0.0;
    for (std::size_t k = 0; k < kTogether; ++k) {
      const double right = at[0][k] + at[2][k], left = at[1][k] + at[3][k];
      const double right_odd = at[0][k] - at[2][k], left_odd = at[1][k] - at[3][k];
      to[k] = right + left;
      to[of_class + k] = right - left;
      to[2 * of_class + k] = right_odd + left_odd;
      to[3 * of_class + k] = right_odd - left_odd;
    }
  }
}

void HeightProducts::add_block(std::span<const Eigen::ArrayXd> weights, int columns, Index begin, int used,
                               std::vector<CacheLine>* scratch, double* sums) const {
  const std::size_t of_class = std::size_t(kBlockOrbits) * std::size_t(columns);
  const std::size_t basis_size = std::max({2 * std::size_t(zernike_.longest()) * kBlockOrbits,
                                           std::size_t(kFourierBasis), spherical_.size() * kBlockOrbits});
  const std::size_t wanted = cache_lines(4 * of_class + cache_aligned(basis_size) + 2 * kBlockOrbits);
  if (scratch->size() < wanted) scratch->resize(wanted);
  double* const folded = scratch->front().lane;
  double* const x = folded + 4 * of_class;
  double* const y = x + kBlockOrbits;
  double* const basis = y + kBlockOrbits;

  OrbitBlock block{(used + 7) / 8 * 8, columns, x, y, {}};
  std::fill(folded, folded + (folded_ ? 4 : 1) * of_class, 0.0);
  std::fill(x, x + 2 * kBlockOrbits, 0.0);
  for (std::size_t c = 0; c < 4; ++c) block.weights[c] = folded + c * of_class;
  for (std::size_t first = 0; first < weights.size(); first += kTogether)
    fold(weights.subspan(first, std::min(kTogether, weights.size() - first)), begin, used, columns, of_class,
         folded + first);
  double* const fourier_sums = sums + 2 * zernike_.rows() * std::size_t(columns);
  if (fourier_.modes() > 0) {
    std::copy_n(x_.data() + begin, used, x);
    std::copy_n(y_.data() + begin, used, y);
    fourier_heights(set_, fourier_.modes(), fourier_.frequency.data(), folded_, block, basis, fourier_sums);
  }
  if (zernike_.rows() == 0 && spherical_.empty()) return;
  for (int p = 0; p < used; ++p) {
    x[p] = x_[begin + p] / radius_;
    y[p] = y_[begin + p] / radius_;
    for (std::size_t j = 0; j < spherical_.size(); ++j)
      basis[j * kBlockOrbits + std::size_t(p)] = std::pow(x[p] * x[p] + y[p] * y[p], spherical_[j] / 2);
  }
  if (!spherical_.empty()) {
    for (std::size_t j = 0; j < spherical_.size(); ++j)
      std::fill(basis + j * kBlockOrbits + std::size_t(used), basis + (j + 1) * kBlockOrbits, 0.0);
    add_height_products(set_, int(spherical_.size()), basis, block,
                        fourier_sums + 2 * std::size_t(fourier_.modes()) * std::size_t(columns));
  }
  if (zernike_.rows() == 0) return;
  for (int p = 0; hold_at_rim_ && p < used; ++p) {
    const double rho2 = x[p] * x[p] + y[p] * y[p];
    if (!(rho2 > 1)) continue;
    const double shrink = 1 / std::sqrt(rho2);
    x[p] *= shrink;
    y[p] *= shrink;
  }
  zernike_heights(set_, zernike_.m_max(), zernike_.first.data(), zernike_.recurrence.data(), folded_, block,
                  basis, sums);
}

Eigen::MatrixXd HeightProducts::operator()(std::span<const Eigen::ArrayXd> weights, int threads) const {
  const int columns = int((weights.size() + 7) / 8 * 8);
  const auto size = std::size_t(columns) * sums_rows();
  const auto chunks = std::size_t((x_.size() + kChunkOrbits - 1) / kChunkOrbits);
  const auto partial = sums_.take();
  const auto add_chunk = [&](std::size_t chunk, double* sums) {
    const auto scratch = scratch_.take();
    const Index end = std::min(x_.size(), Index(chunk + 1) * kChunkOrbits);
    for (Index at = Index(chunk) * kChunkOrbits; at < end; at += kBlockOrbits)
      add_block(weights, columns, at, int(std::min<Index>(kBlockOrbits, end - at)), &*scratch, sums);
  };
  sum_chunks(chunks, size, threads, add_chunk, &*partial);

  const auto zernikes = Index(zernike_.slot.size()), others = Index(sums_rows() - 2 * zernike_.rows());
  Eigen::MatrixXd result(zernikes + others, Index(weights.size()));
  const double* total = partial->total.data();
  for (Index k = 0; k < result.cols(); ++k) {
    for (Index j = 0; j < zernikes; ++j)
      result(j, k) =
          zernike_.scale[std::size_t(j)] * total[Index(zernike_.slot[std::size_t(j)]) * columns + k];
    for (Index j = 0; j < others; ++j)
      result(zernikes + j, k) = total[(Index(2 * zernike_.rows()) + j) * columns + k];
  }
  return result;
}

}  // namespace aberfit::internal
