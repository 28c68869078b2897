#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "aberfit/core/errors.h"
#include "aberfit/scene/aperture.h"

namespace aberfit {
namespace {

// A crossing between two neighbouring pixels of a row or a column, named by the first pixel.
struct Crossing {
  Eigen::Index row, column;
  bool along_row;
  auto operator<=>(const Crossing&) const = default;
};

class Outliner {
 public:
  explicit Outliner(const Eigen::ArrayXXd& share)
      : share_(Eigen::ArrayXXd::Zero(share.rows() + 2, share.cols() + 2)) {
    share_.block(1, 1, share.rows(), share.cols()) = share.isFinite().select(share, 0.0);
  }

  std::vector<Outline> outlines(double pitch) {
    for (Eigen::Index row = 0; row + 1 < share_.rows(); ++row)
      for (Eigen::Index column = 0; column + 1 < share_.cols(); ++column) add_lines(row, column);
    std::vector<Outline> result;
    while (!next_.empty()) {
      Outline& outline = result.emplace_back();
      for (auto line = next_.begin(); line != next_.end();) {
        const Crossing to = line->second;
        outline.push_back(place(line->first, pitch));
        next_.erase(line);
        line = next_.find(to);
      }
      drop_straight(&outline);
    }
    return result;
  }

 private:
  bool clear(Eigen::Index row, Eigen::Index column) const { return share_(row, column) > 0.5; }

  // Marching squares: lines between the centres of the four pixels from (row, column) on, with the clear area
  // on their left. Two clear pixels that touch only at a corner stay separate.
  void add_lines(Eigen::Index row, Eigen::Index column) {
    const Crossing low{row, column, true}, high{row + 1, column, true}, left{row, column, false},
        right{row, column + 1, false};
    const bool corner[4] = {clear(row, column), clear(row, column + 1), clear(row + 1, column + 1),
                            clear(row + 1, column)};  // counter-clockwise, like the sides below
    const Crossing side[4] = {low, right, high, left};
    for (int k = 0; k < 4; ++k) {
      if (!corner[k] || corner[(k + 1) % 4]) continue;  // the clear area ends on side k
      int before = (k + 3) % 4;
      while (corner[before]) before = (before + 3) % 4;
      next_.emplace(side[k], side[before]);
    }
  }

  // Point between two pixels where the transmission is one half, from the centre of the mask [m].
  std::array<double, 2> place(const Crossing& at, double pitch) const {
    const double here = share_(at.row, at.column),
                 there = share_(at.row + (at.along_row ? 0 : 1), at.column + (at.along_row ? 1 : 0));
    const double part = (0.5 - here) / (there - here);
    return {pitch * (double(at.column) + (at.along_row ? part : 0) - 0.5 * double(share_.cols() - 1)),
            pitch * (double(at.row) + (at.along_row ? 0 : part) - 0.5 * double(share_.rows() - 1))};
  }

  static void drop_straight(Outline* outline) {
    constexpr double kStraight = 1e-9;
    Outline kept;
    const std::size_t n = outline->size();
    for (std::size_t i = 0; i < n; ++i) {
      const auto &a = (*outline)[(i + n - 1) % n], &b = (*outline)[i], &c = (*outline)[(i + 1) % n];
      const double ux = b[0] - a[0], uy = b[1] - a[1], vx = c[0] - b[0], vy = c[1] - b[1];
      if (std::abs(ux * vy - uy * vx) > kStraight * std::hypot(ux, uy) * std::hypot(vx, vy))
        kept.push_back(b);
    }
    *outline = std::move(kept);
  }

  Eigen::ArrayXXd share_;
  std::map<Crossing, Crossing> next_;
};

}  // namespace

SegmentedAperture mask_outlines(const Eigen::ArrayXXd& share, double pitch) {
  SegmentedAperture result{Outliner(share).outlines(pitch), 0};
  const double area = result.outlines.empty() ? 0 : aperture_area(result),
               clear = pitch * pitch * share.isFinite().select(share, 0.0).sum();
  if (area == 0) throw ComputationError("the mask has no pixel above one half");
  constexpr double kGreyArea = 0.01;
  if (std::abs(area / clear - 1) > kGreyArea)
    throw ComputationError(
        "the mask is grey not only at its edges: its sum and the area inside its outline differ by more than "
        "1 %");
  return result;
}

}  // namespace aberfit
