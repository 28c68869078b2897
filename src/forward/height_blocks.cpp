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
  throw std::invalid_argument("blocks of heights need the points of a grid");
}

double pitch_of(const Eigen::ArrayXd& centres) {
  return centres.size() < 2 ? 0 : (centres[centres.size() - 1] - centres[0]) / double(centres.size() - 1);
}

// Blocks of a line of grid cells, symmetric about its middle. The middle cell of an odd line lies in the
// middle of an odd block; otherwise a block begins at the middle.
struct Line {
  Line(const Eigen::ArrayXd& centres, int side) {
    const auto count = int(centres.size());
    const bool middle = count % 2 == 1 && side % 2 == 1;
    const int first = middle ? (count / 2 - side / 2) % side : (count / 2) % side;  // of a whole block
    const int before = first == 0 ? 0 : 1;
    const double pitch = pitch_of(centres);
    blocks.resize(std::size_t(count));
    for (int i = 0; i < count; ++i)
      blocks[std::size_t(i)] = std::uint32_t((i - first + before * side) / side);
    places.resize(Eigen::Index(blocks.back()) + 1);
    for (Eigen::Index b = 0; b < places.size(); ++b) {
      const double begin = first + double(b - before) * side;  // cell index
      places[b] = centres[0] + (begin + 0.5 * (side - 1)) * pitch;
    }
  }
  std::vector<std::uint32_t> blocks;
  Eigen::ArrayXd places;
};

// Distance on the mirror over f times the direction cosine: 1 + t^2, t = tan of half the angle.
double stretch(double x, double y, double focal_length) {
  const double sine2 = std::min(1.0, (x * x + y * y) / (focal_length * focal_length)),
               cosine = std::sqrt(1 - sine2);
  return 2 / (1 + cosine);
}

struct Points {
  CartesianGrid grid;
  std::vector<double> x = {}, y = {};

  std::size_t size() const { return x.size(); }
  void add(std::uint32_t column, std::uint32_t row, std::array<double, 2> at) {
    grid.column.push_back(column);
    grid.row.push_back(row);
    x.push_back(at[0]);
    y.push_back(at[1]);
  }
  PupilSample sample(const Cells& like) && {
    PupilSample result;
    const auto n = Eigen::Index(x.size());
    result.x = Eigen::Map<const Eigen::ArrayXd>(x.data(), n);
    result.y = Eigen::Map<const Eigen::ArrayXd>(y.data(), n);
    result.weight = Eigen::ArrayXd::Constant(n, 1 / double(n));
    result.layout = PupilLayout::kGrid;
    if (std::isfinite(like.focal_length))
      result.structure = DirectionGrid{std::move(grid), like.focal_length, like.shift};
    else
      result.structure = std::move(grid);
    return result;
  }
};

// Distance [blocks] from the rim of the Zernikes; nearer, errors reach a tenth of the largest derivative.
constexpr double kBlocksOfRim = 3;

}  // namespace

int HeightBlocks::side(const TermSet& terms, const PupilSample& cells) {
  const Cells at = cells_of(cells);
  const int side = height_block_side(terms, std::max(pitch_of(at.grid.x), pitch_of(at.grid.y)), cells.size());
  // Blocks that mirror each other share their products.
  const bool odd = at.grid.x.size() % 2 == 1 || at.grid.y.size() % 2 == 1;
  return odd && side % 2 == 0 ? side - 1 : side;
}

HeightBlocks::HeightBlocks(const TermSet& all, const PupilSample& cells, int side,
                           const OperatorOptions& options)
    : place_(std::size_t(cells.size())), terms_(all.size()) {
  const TermSet terms = all.without_segments();
  if (all.of_a_segment() > 0) {
    TermSet steps;
    steps.segments = all.segments;
    of_segments_ = std::make_unique<const SurfaceOperator>(std::move(steps), cells, options);
  }
  const Cells at = cells_of(cells);
  const Line columns(at.grid.x, side), rows(at.grid.y, side);
  const double rim =
      terms.zernike.empty() || side == 1
          ? HUGE_VAL
          : terms.radius - kBlocksOfRim * side * std::max(pitch_of(at.grid.x), pitch_of(at.grid.y));
  const auto stretched = [&](double x, double y) {
    const double longer = std::isfinite(at.focal_length) ? stretch(x, y, at.focal_length) : 1;
    return std::array<double, 2>{x * longer, y * longer};
  };
  constexpr std::uint32_t kNew = UINT32_MAX, kCells = UINT32_MAX - 1;
  const auto width = std::size_t(columns.places.size());
  std::vector<std::uint32_t> numbers(width * std::size_t(rows.places.size()), kNew);
  Points blocks{{columns.places, rows.places, {}, {}}}, singles{{at.grid.x, at.grid.y, {}, {}}};
  std::vector<std::size_t> alone;
  for (std::size_t k = 0; k < place_.size(); ++k) {
    const std::uint32_t column = columns.blocks[at.grid.column[k]], row = rows.blocks[at.grid.row[k]];
    std::uint32_t& number = numbers[row * width + column];
    if (number == kNew) {
      const auto middle = stretched(columns.places[column], rows.places[row]);
      number = std::hypot(middle[0], middle[1]) > rim ? kCells : std::uint32_t(blocks.size());
      if (number != kCells) blocks.add(column, row, middle);
    }
    if (number == kCells) {
      alone.push_back(k);
      singles.add(at.grid.column[k], at.grid.row[k], {cells.x[Eigen::Index(k)], cells.y[Eigen::Index(k)]});
    } else {
      place_[k] = number;
    }
  }
  blocks_ = Eigen::Index(blocks.size());
  at_rim_ = Eigen::Index(singles.size());
  for (std::size_t j = 0; j < alone.size(); ++j) place_[alone[j]] = std::uint32_t(blocks.size() + j);
  if (blocks_ > 0)
    of_blocks_ = std::make_unique<const SurfaceOperator>(terms, std::move(blocks).sample(at), options);
  if (at_rim_ > 0)
    of_cells_ = std::make_unique<const SurfaceOperator>(terms, std::move(singles).sample(at), options);
}

Eigen::ArrayXd HeightBlocks::sums(const Eigen::ArrayXd& weights) const {
  Eigen::ArrayXd result = Eigen::ArrayXd::Zero(blocks_ + at_rim_);
  for (std::size_t k = 0; k < place_.size(); ++k) result[place_[k]] += weights[Eigen::Index(k)];
  if (!of_segments_) return result;
  const Eigen::VectorXd of_segments = of_segments_->apply_transpose_heights(std::span(&weights, 1));
  Eigen::ArrayXd both(result.size() + of_segments.size());
  both << result, of_segments.array();
  return both;
}

Eigen::MatrixXd HeightBlocks::products(std::span<const Eigen::ArrayXd> sums) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(terms_, Eigen::Index(sums.size()));
  const auto add = [&](const SurfaceOperator* surface, Eigen::Index first, Eigen::Index size) {
    if (!surface) return;
    std::vector<Eigen::ArrayXd> part;
    for (const Eigen::ArrayXd& sum : sums) part.push_back(sum.segment(first, size));
    result.topRows(surface->terms().size()) += surface->apply_transpose_heights(part);
  };
  add(of_blocks_.get(), 0, blocks_);
  add(of_cells_.get(), blocks_, at_rim_);
  if (of_segments_)
    for (std::size_t k = 0; k < sums.size(); ++k) {
      const Eigen::Index count = of_segments_->terms().size();
      result.col(Eigen::Index(k)).tail(count) = sums[k].tail(count);
    }
  return result;
}

}  // namespace aberfit::internal
