#include "height_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "aberfit/forward/height_block_side.h"
#include "aberfit/scene/zernike.h"

namespace aberfit {

int height_block_side(const TermSet& terms, double pitch, Eigen::Index cells) {
  constexpr double kMost = 64;
  double highest = 0;  // [cycles/m]
  for (const FourierMode& mode : terms.fourier) highest = std::max(highest, std::hypot(mode.fx, mode.fy));
  for (const ZernikeMode& mode : terms.zernike)
    highest = std::max(highest, zernike_cutoff(mode.n, terms.radius));
  if (cells < kFewestBlockedCells || !(highest > 0) || !(pitch > 0)) return 1;
  return std::max(1, int(std::min(kMost, 1 / (kBlocksACycle * highest * pitch))));
}

}  // namespace aberfit

namespace aberfit::internal {
namespace {

struct Cells {
  const CartesianGrid& grid;
  double focal_length;  // infinite: steps on the mirror
  std::array<double, 2> shift;
};

Cells cells_of(const PupilSample& pupil) {
  if (const auto* directions = std::get_if<DirectionGrid>(&pupil.structure))
    return {directions->cells, directions->focal_length, directions->shift};
  if (const auto* grid = std::get_if<CartesianGrid>(&pupil.structure)) return {*grid, HUGE_VAL, {}};
  throw std::invalid_argument("blocks of heights need the cells of a grid");
}

double pitch_of(const Eigen::ArrayXd& centres) {
  return centres.size() < 2 ? 0 : (centres[centres.size() - 1] - centres[0]) / double(centres.size() - 1);
}

// Blocks of a line of cells, symmetric about its middle: an odd number of cells has one block about the
// middle cell where a block has a middle, else blocks begin there.
struct Line {
  Line(const Eigen::ArrayXd& centres, int side) {
    const auto count = int(centres.size());
    const bool middle = count % 2 == 1 && side % 2 == 1;
    const int first = middle ? (count / 2 - side / 2) % side : (count / 2) % side;  // where a block begins
    const int before = first == 0 ? 0 : 1;
    const double pitch = pitch_of(centres);
    blocks.resize(std::size_t(count));
    for (int i = 0; i < count; ++i)
      blocks[std::size_t(i)] = std::uint32_t((i - first + before * side) / side);
    places.resize(Eigen::Index(blocks.back()) + 1);
    for (Eigen::Index b = 0; b < places.size(); ++b) {
      const double begin = first + double(b - before) * side;  // cell
      places[b] = centres[0] + (begin + 0.5 * (side - 1)) * pitch;
    }
  }
  std::vector<std::uint32_t> blocks;
  Eigen::ArrayXd places;
};

// On the mirror over f times the direction cosine, 1 + t^2, t = tan of half the angle.
double stretch(double x, double y, double focal_length) {
  const double sine2 = std::min(1.0, (x * x + y * y) / (focal_length * focal_length)),
               cosine = std::sqrt(1 - sine2);
  return 2 / (1 + cosine);
}

}  // namespace

int HeightBlocks::side(const TermSet& terms, const PupilSample& cells) {
  const Cells at = cells_of(cells);
  const int side = height_block_side(terms, std::max(pitch_of(at.grid.x), pitch_of(at.grid.y)), cells.size());
  // Blocks that mirror each other share their products.
  const bool odd = at.grid.x.size() % 2 == 1 || at.grid.y.size() % 2 == 1;
  return odd && side % 2 == 0 ? side - 1 : side;
}

HeightBlocks::HeightBlocks(const TermSet& terms, const PupilSample& cells, int side,
                           const OperatorOptions& options) {
  const Cells at = cells_of(cells);
  const Line columns(at.grid.x, side), rows(at.grid.y, side);
  const auto width = std::size_t(columns.places.size());
  std::vector<std::uint32_t> numbers(width * std::size_t(rows.places.size()), UINT32_MAX);
  CartesianGrid grid{columns.places, rows.places, {}, {}};
  block_.resize(std::size_t(cells.size()));
  for (std::size_t k = 0; k < block_.size(); ++k) {
    const std::uint32_t column = columns.blocks[at.grid.column[k]], row = rows.blocks[at.grid.row[k]];
    std::uint32_t& number = numbers[row * width + column];
    if (number == UINT32_MAX) {
      number = std::uint32_t(blocks_++);
      grid.column.push_back(column);
      grid.row.push_back(row);
    }
    block_[k] = number;
  }
  PupilSample blocks;
  blocks.x.resize(blocks_);
  blocks.y.resize(blocks_);
  blocks.weight = Eigen::ArrayXd::Constant(blocks_, 1 / double(blocks_));
  blocks.layout = PupilLayout::kGrid;
  for (Eigen::Index b = 0; b < blocks_; ++b) {
    const double x = grid.x[grid.column[std::size_t(b)]], y = grid.y[grid.row[std::size_t(b)]];
    const double longer = std::isfinite(at.focal_length) ? stretch(x, y, at.focal_length) : 1;
    blocks.x[b] = x * longer;
    blocks.y[b] = y * longer;
  }
  if (std::isfinite(at.focal_length))
    blocks.structure = DirectionGrid{std::move(grid), at.focal_length, {}};
  else
    blocks.structure = std::move(grid);
  surface_ = std::make_unique<const SurfaceOperator>(terms, blocks, options);
}

Eigen::ArrayXd HeightBlocks::sums(const Eigen::ArrayXd& weights) const {
  Eigen::ArrayXd result = Eigen::ArrayXd::Zero(blocks_);
  for (std::size_t k = 0; k < block_.size(); ++k) result[block_[k]] += weights[Eigen::Index(k)];
  return result;
}

}  // namespace aberfit::internal
