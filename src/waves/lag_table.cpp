#include "aberfit/waves/lag_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace aberfit {
namespace {

// Lagrange weights of the ten equidistant nodes 0 .. 9 at t.
void lagrange(double t, double* weights) {
  constexpr int kNodes = 10;
  // 1/((-1)^(9-i) i! (9-i)!)
  static constexpr double kScale[kNodes] = {-1.0 / 362880, 1.0 / 40320, -1.0 / 10080, 1.0 / 4320,
                                            -1.0 / 2880,   1.0 / 2880,  -1.0 / 4320,  1.0 / 10080,
                                            -1.0 / 40320,  1.0 / 362880};
  double below[kNodes], above = 1;
  below[0] = 1;
  for (int i = 1; i < kNodes; ++i) below[i] = below[i - 1] * (t - (i - 1));
  for (int i = kNodes - 1; i >= 0; --i) {
    weights[i] = kScale[i] * below[i] * above;
    above *= t - i;
  }
}

}  // namespace

LagTable::LagTable(int rows, int columns, double ax, double ay, double longest)
    : columns_(std::size_t(columns)),
      nodes_(Eigen::Index(longest * kNodesPerLag) + 7),
      within_(std::size_t(rows), 0),
      index_(std::size_t(rows) * columns_, 0) {
  const double longest2 = longest * longest;
  std::vector<std::pair<double, std::size_t>> lags;  // length^2 and index
  for (int row = 0; row < rows; ++row) {
    const double y2 = double(row) * row * ay * ay;
    for (int column = 0; column < columns; ++column) {
      const double s2 = y2 + double(column) * column * ax * ax;
      if (s2 > longest2) break;
      ++within_[std::size_t(row)];
      lags.emplace_back(s2, std::size_t(row) * columns_ + std::size_t(column));
    }
  }
  std::sort(lags.begin(), lags.end());
  double last = -1;
  for (const auto& [s2, place] : lags) {
    if (s2 != last) {
      const double x = std::sqrt(s2) * kNodesPerLag;
      const int node = int(x);
      first_.push_back(node);
      weights_.resize(weights_.size() + kSpread);
      lagrange(x - (node - kBelow), weights_.data() + weights_.size() - kSpread);
      last = s2;
    }
    index_[place] = std::uint32_t(first_.size() - 1);
  }
}

Eigen::ArrayXd LagTable::to_nodes(const Eigen::ArrayXd& sums) const {
  Eigen::ArrayXd spread = Eigen::ArrayXd::Zero(nodes_ + kBelow);
  const double* weight = weights_.data();
  for (std::size_t k = 0; k < first_.size(); ++k, weight += kSpread) {
    double* node = spread.data() + first_[k];
    const double sum = sums[Eigen::Index(k)];
    for (int i = 0; i < kSpread; ++i) node[i] += weight[i] * sum;
  }
  Eigen::ArrayXd values = spread.tail(nodes_);
  for (int i = 1; i <= kBelow; ++i) values[i] += spread[kBelow - i];
  return values;
}

Eigen::ArrayXd LagTable::at_lengths(const Eigen::ArrayXd& g) const {
  Eigen::ArrayXd spread(nodes_ + kBelow);
  spread.tail(nodes_) = g;
  for (int i = 1; i <= kBelow; ++i) spread[kBelow - i] = g[i];
  Eigen::ArrayXd values(lengths());
  const double* weight = weights_.data();
  for (std::size_t k = 0; k < first_.size(); ++k, weight += kSpread) {
    const double* node = spread.data() + first_[k];
    double even = 0, odd = 0;
    for (int i = 0; i < kSpread; i += 2) {
      even += weight[i] * node[i];
      odd += weight[i + 1] * node[i + 1];
    }
    values[Eigen::Index(k)] = even + odd;
  }
  return values;
}

}  // namespace aberfit
