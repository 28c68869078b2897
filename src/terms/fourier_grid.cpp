#include "fourier_grid.h"

#include <algorithm>
#include <numeric>

#include "aberfit/core/parallel.h"

namespace aberfit::internal {
namespace {

using Eigen::Index;

struct Stretch {
  int begin, count;
};

/// [0, count) in as few about equal stretches of at most `longest` as possible, their lengths multiples of
/// `unit` except the last.
std::vector<Stretch> stretches(int count, int longest, int unit) {
  const int parts = (count + longest - 1) / longest;
  std::vector<Stretch> result;
  for (int begin = 0; begin < count;) {
    const int wanted = (count + parts - 1) / parts;
    const int length = std::min(count - begin, (wanted + unit - 1) / unit * unit);
    result.push_back({begin, length});
    begin += length;
  }
  return result;
}

}  // namespace

FourierGrid::FourierGrid(const TermSet& terms, const CartesianGrid& grid)
    : rows_(fourier_rows(terms.fourier)),
      begin_(terms.fourier_begin()),
      x_(grid.x),
      y_(grid.y),
      point_(grid.column.size()),
      column_(grid.column.size()),
      set_(best_instruction_set()) {
  std::iota(point_.begin(), point_.end(), 0u);
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    if (grid.row[a] != grid.row[b]) return grid.row[a] < grid.row[b];
    return grid.column[a] != grid.column[b] ? grid.column[a] < grid.column[b] : a < b;
  };
  if (!std::is_sorted(point_.begin(), point_.end(), before)) std::sort(point_.begin(), point_.end(), before);
  row_begin_.assign(std::size_t(y_.size()) + 1, 0);
  for (std::size_t i = 0; i < point_.size(); ++i) {
    column_[i] = grid.column[point_[i]];
    ++row_begin_[grid.row[point_[i]] + 1];
  }
  std::partial_sum(row_begin_.begin(), row_begin_.end(), row_begin_.begin());

  for (const Stretch row : stretches(int(y_.size()), kTileRows, kRowGroup))
    for (const Stretch column : stretches(int(x_.size()), kTileColumns, kColumnGroup)) {
      const Span span{row.begin, row.count, column.begin, column.count};
      bool any = false;
      for_points(span, [&any](int, int, std::uint32_t) { any = true; });
      if (any) tiles_.push_back(span);
    }
}

template <typename Visit>
void FourierGrid::for_points(const Span& span, const Visit& visit) const {
  for (int j = 0; j < span.rows; ++j) {
    const auto row = column_.begin() + std::ptrdiff_t(row_begin_[std::size_t(span.row + j)]);
    const auto row_end = column_.begin() + std::ptrdiff_t(row_begin_[std::size_t(span.row + j) + 1]);
    for (auto at = std::lower_bound(row, row_end, std::uint32_t(span.column));
         at != row_end && *at < std::uint32_t(span.column + span.columns); ++at)
      visit(j, int(*at) - span.column, point_[std::size_t(at - column_.begin())]);
  }
}

/// Coordinates, wanted columns, and zeros for the field there.
void FourierGrid::prepare(const Span& span, GridTile* tile) const {
  tile->rows = span.rows;
  tile->columns = span.columns;
  std::fill(tile->x, tile->x + kTileColumns, 0.0);
  std::fill(tile->y, tile->y + kTileRows, 0.0);
  std::copy_n(x_.data() + span.column, span.columns, tile->x);
  std::copy_n(y_.data() + span.row, span.rows, tile->y);
  std::fill(std::begin(tile->from), std::end(tile->from), kTileColumns);
  std::fill(std::begin(tile->to), std::end(tile->to), 0);
  for_points(span, [&](int j, int i, std::uint32_t) {
    int &from = tile->from[j / kRowGroup], &to = tile->to[j / kRowGroup];
    from = std::min(from, i / kColumnGroup * kColumnGroup);
    to = std::max(to, (i / kColumnGroup + 1) * kColumnGroup);
  });
  for (int j = 0; j < kTileRows; ++j) {
    const int from = tile->from[j / kRowGroup], to = tile->to[j / kRowGroup];
    if (from >= to) continue;
    for (auto* plane : {tile->height, tile->slope_x, tile->slope_y})
      std::fill(plane[j] + from, plane[j] + to, 0.0);
  }
}

void FourierGrid::forward(const Eigen::VectorXd& coefficients, int threads, bool add,
                          SurfaceField* field) const {
  parallel_for(tiles_.size(), threads, [&](std::size_t i) {
    const auto tile = scratch_.take();
    prepare(tiles_[i], &*tile);
    grid_forward(set_, rows_, coefficients.data() + begin_, &*tile);
    for_points(tiles_[i], [&](int row, int column, std::uint32_t point) {
      deliver(&tile->height[row][column], 1, add, &field->height[point]);
      deliver(&tile->slope_x[row][column], 1, add, &field->slope_x[point]);
      deliver(&tile->slope_y[row][column], 1, add, &field->slope_y[point]);
    });
  });
}

void FourierGrid::adjoint(const SurfaceField& weights, int threads, Eigen::VectorXd* sums) const {
  const auto partial = sums_.take();
  const auto add_tile = [&](std::size_t i, double* amplitudes) {
    const auto tile = scratch_.take();
    prepare(tiles_[i], &*tile);
    for_points(tiles_[i], [&](int row, int column, std::uint32_t point) {
      // Several points may share a place.
      tile->height[row][column] += weights.height[point];
      tile->slope_x[row][column] += weights.slope_x[point];
      tile->slope_y[row][column] += weights.slope_y[point];
    });
    grid_adjoint(set_, rows_, &*tile, amplitudes);
  };
  const std::size_t size = 2 * std::size_t(rows_.modes());
  sum_chunks(tiles_.size(), size, threads, add_tile, &*partial);
  std::copy_n(partial->total.data(), size, sums->data() + begin_);
}

}  // namespace aberfit::internal
