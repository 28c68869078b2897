#include "aberfit/measured/padding.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "aberfit/core/constants.h"
#include "convex_rows.h"

namespace aberfit {
namespace {

using Eigen::Index;

constexpr double kManyPoints = 0.01;    // fraction of the valid points
constexpr double kStandsOut = 2;        // ratio to the points of a neighbouring height
constexpr double kLeftByOneStep = 0.5;  // fraction of the points beside it

// A frequent height and its neighbours in the sorted list of heights.
struct Level {
  double height = 0, below = kNaN, above = kNaN;
  // Points with this height, and the larger number of points of its two neighbours.
  Index points = 0, most_beside = 0;
};

struct Levels {
  std::vector<Level> frequent;
  double step = kInfinity;  // smallest difference of two heights: the rounding step, if they are rounded
  Index heights = 0;        // number of different heights
};

// `sorted`: all heights, ascending. A map may have 1e8 points, so only frequent heights are kept.
Levels levels_of(const std::vector<double>& sorted, double many) {
  Levels levels;
  Level before;
  bool frequent_before = false;
  for (std::size_t begin = 0; begin < sorted.size();) {
    std::size_t end = begin;
    while (end < sorted.size() && sorted[end] == sorted[begin]) ++end;
    Level level{sorted[begin], before.points > 0 ? before.height : kNaN, kNaN, Index(end - begin),
                before.points};
    if (before.points > 0) levels.step = std::min(levels.step, level.height - before.height);
    if (frequent_before) {
      Level& last = levels.frequent.back();
      last.above = level.height;
      last.most_beside = std::max(last.most_beside, level.points);
    }
    frequent_before = double(level.points) > many;
    if (frequent_before) levels.frequent.push_back(level);
    ++levels.heights;
    before = level;
    begin = end;
  }
  return levels;
}

template <class Use>
void each_neighbour(const Grid& height, Index row, Index column, const Use& use) {
  if (row > 0) use(row - 1, column);
  if (row + 1 < height.rows()) use(row + 1, column);
  if (column > 0) use(row, column - 1);
  if (column + 1 < height.cols()) use(row, column + 1);
}

// True if the points beside this height are one rounding step away, as on a rounded surface.
bool left_by_one_step(const Grid& height, const Level& level, double step) {
  constexpr double kRounding = 1.5;  // unit conversion changes steps slightly; two steps stay distinct
  Index beside = 0, one_step = 0;
  for (Index row = 0; row < height.rows(); ++row)
    for (Index column = 0; column < height.cols(); ++column) {
      const double there = height(row, column);
      if (!std::isfinite(there) || there == level.height) continue;
      bool touches = false;
      each_neighbour(height, row, column, [&](Index r, Index c) { touches |= height(r, c) == level.height; });
      if (!touches) continue;
      ++beside;
      const bool next = there == level.below || there == level.above;
      if (next && std::abs(there - level.height) <= kRounding * step) ++one_step;
    }
  return beside > 0 && double(one_step) >= kLeftByOneStep * double(beside);
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// True if the surface crosses this height along lines, as astigmatism crosses zero: the points cover no area,
// and their neighbours are as far from them as from the next points.
bool is_crossed(const Grid& height, double level) {
  constexpr double kInside = 0.25, kContinuous = 2;
  const auto at = [&](Index r, Index c) {
    return r < 0 || c < 0 || r >= height.rows() || c >= height.cols() ? kNaN : height(r, c);
  };
  Index points = 0, inside = 0;
  std::vector<double> to_level, onwards;
  for (Index row = 0; row < height.rows(); ++row)
    for (Index column = 0; column < height.cols(); ++column) {
      if (height(row, column) != level) continue;
      ++points;
      bool alone = true;
      for (const auto& [down, right] : {std::pair<Index, Index>(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
        const double beside = at(row + down, column + right), next = at(row + 2 * down, column + 2 * right);
        if (!std::isfinite(beside) || beside == level) continue;
        alone = false;
        if (!std::isfinite(next) || next == level) continue;
        to_level.push_back(std::abs(beside - level));
        onwards.push_back(std::abs(next - beside));
      }
      if (alone) ++inside;
    }
  return double(inside) < kInside * double(points) &&
         median_of(std::move(to_level)) <= kContinuous * median_of(std::move(onwards));
}

std::optional<Level> most_frequent_padding(const Grid& height, const std::vector<double>& sorted,
                                           double many) {
  Levels levels = levels_of(sorted, many);
  if (levels.heights < 2) return std::nullopt;
  std::sort(levels.frequent.begin(), levels.frequent.end(),
            [](const Level& a, const Level& b) { return a.points > b.points; });
  for (const Level& level : levels.frequent)
    if (double(level.points) > kStandsOut * double(level.most_beside) &&
        !left_by_one_step(height, level, levels.step) && !is_crossed(height, level.height))
      return level;
  return std::nullopt;
}

// Number of connected blocks of marked points, along rows and columns.
Index blocks_of(const Mask& marked) {
  Mask left = marked;
  Index blocks = 0;
  std::vector<std::pair<Index, Index>> stack;
  for (Index row = 0; row < left.rows(); ++row)
    for (Index column = 0; column < left.cols(); ++column) {
      if (!left(row, column)) continue;
      ++blocks;
      left(row, column) = false;
      stack.assign(1, {row, column});
      while (!stack.empty()) {
        const auto [r, c] = stack.back();
        stack.pop_back();
        for (const auto& [y, x] : {std::pair(r - 1, c), {r + 1, c}, {r, c - 1}, {r, c + 1}})
          if (y >= 0 && x >= 0 && y < left.rows() && x < left.cols() && left(y, x))
            left(y, x) = false, stack.emplace_back(y, x);
      }
    }
  return blocks;
}

}  // namespace

Mask padded_points(const HeightMap& map, const std::vector<Padding>& padding) {
  Mask marked = Mask::Constant(map.rows(), map.columns(), false);
  for (const Padding& one : padding) marked = marked || map.height == one.height;
  return marked;
}

std::vector<Padding> find_padding(const HeightMap& map) {
  std::vector<double> sorted;
  for (const double h : map.height.reshaped())
    if (std::isfinite(h)) sorted.push_back(h);
  const double many = kManyPoints * double(sorted.size());
  std::sort(sorted.begin(), sorted.end());
  std::vector<Padding> padding;
  HeightMap rest = map;
  // Two marks that are neighbours in the list, such as 0 and -9999, would hide each other.
  while (const auto found = most_frequent_padding(rest.height, sorted, many)) {
    padding.push_back({found->height, found->points, 0, 0});
    rest.height = (rest.height == found->height).select(kNaN, rest.height);
    const auto [begin, end] = std::equal_range(sorted.begin(), sorted.end(), found->height);
    sorted.erase(begin, end);
  }
  if (padding.empty()) return padding;
  const std::vector<std::pair<double, double>> hull = internal::convex_rows(rest);
  for (Padding& one : padding) {
    const Mask marked = map.height == one.height;
    one.blocks = blocks_of(marked);
    for (Index row = 0; row < marked.rows(); ++row)
      for (Index column = 0; column < marked.cols(); ++column) {
        const auto [first, last] = hull[std::size_t(row)];
        if (marked(row, column) && !(double(column) >= first && double(column) <= last)) ++one.outside;
      }
  }
  return padding;
}

}  // namespace aberfit
