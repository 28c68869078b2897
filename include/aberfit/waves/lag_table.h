#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace aberfit {

/// Groups the lags (column, row) >= 0 of a pupil grid by length, in units of the smaller pitch. With square
/// cells, a quarter of the lags have a distinct length. Lagrange weights distribute each length over ten
/// nodes s_j = j/kNodesPerLag. Then the sum over nodes of T_j g(s_j) is the sum over lags of C_m g(|m|) for
/// every smooth even g. For g(s) = q J1(2 pi q s)/s the error is below 2e-8 of g's size at q = 1/2 (the edge
/// of the field of view) and falls as q^10: 2e-11 at q = 1/4.
class LagTable {
 public:
  static constexpr int kNodesPerLag = 8;

  LagTable() = default;
  /// ax, ay: pitches over the smaller pitch. The pupil has no lags longer than `longest`.
  LagTable(int rows, int columns, double ax, double ay, double longest);

  /// The table has the lags (0, row) .. (columns_within(row) - 1, row).
  int columns_within(int row) const { return within_[std::size_t(row)]; }
  /// Index of the length of each lag in a row.
  const std::uint32_t* length_of(int row) const { return index_.data() + std::size_t(row) * columns_; }
  Eigen::Index lengths() const { return Eigen::Index(first_.size()); }
  Eigen::Index nodes() const { return nodes_; }

  /// Values at the nodes, from the sums over the lags of each length.
  Eigen::ArrayXd to_nodes(const Eigen::ArrayXd& sums) const;
  /// Interpolates g from the nodes to each length; the transpose of to_nodes.
  Eigen::ArrayXd at_lengths(const Eigen::ArrayXd& g) const;

 private:
  static constexpr int kSpread = 10;              // nodes per length
  static constexpr int kBelow = kSpread / 2 - 1;  // nodes below 0, which mirror those above
  std::size_t columns_ = 0;
  Eigen::Index nodes_ = 0;
  std::vector<int> within_;
  std::vector<std::uint32_t> index_;
  std::vector<std::int32_t> first_;  // first of the ten nodes, plus kBelow
  std::vector<double> weights_;      // ten per length
};

}  // namespace aberfit
