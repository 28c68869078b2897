#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

namespace aberfit {

/// The transfer function as far as circles about the focus see it: sums of C_m over lags of equal length, on
/// nodes s_j = j/kNodesPerLag, lags counted in the smaller pitch. Lags between nodes are shared out to ten
/// nodes by Lagrange's weights, so that a sum over nodes of T_j g(s_j) is the sum over lags of C_m g(|m|) for
/// every smooth even g. For g(s) = q J1(2 pi q s)/s, the error is below 2e-8 of g's size at q = 1/2 (the edge
/// of the field of view) and falls as q^10: 2e-11 at q = 1/4.
class RadialOtf {
 public:
  static constexpr int kNodesPerLag = 8;

  RadialOtf() = default;
  explicit RadialOtf(double longest_lag) { values_.setZero(nodes_for(longest_lag)); }
  explicit RadialOtf(Eigen::ArrayXd values) : values_(std::move(values)) {}

  static Eigen::Index nodes_for(double longest_lag) { return Eigen::Index(longest_lag * kNodesPerLag) + 7; }
  const Eigen::ArrayXd& values() const { return values_; }

  void clear() { values_.setZero(); }
  /// Adds `value` at lag length s.
  void add(double s, double value) {
    double weights[kSpread];
    const int first = lagrange(s, weights);
    if (first >= 0) {
      double* node = values_.data() + first;
      for (int i = 0; i < kSpread; ++i) node[i] += weights[i] * value;
    } else {  // nodes below 0 mirror those above
      for (int i = 0; i < kSpread; ++i) values_[std::abs(first + i)] += weights[i] * value;
    }
  }
  void scale(double factor) { values_ *= factor; }

  /// Energy inside the circle of radius q (in periods of the PSF: r u, u = pitch/(lambda f)), and its
  /// derivative by q.
  double energy(double q) const;
  double density(double q) const;
  /// Smallest q <= q_max whose circle holds `fraction`; nothing if none does.
  std::optional<double> radius(double fraction, double q_max) const;

  /// Interpolates g, given at the nodes: what `add` is the transpose of.
  static double interpolate(const Eigen::ArrayXd& g, double s) {
    double weights[kSpread];
    const int first = lagrange(s, weights);
    double sum = 0;
    if (first >= 0) {
      const double* node = g.data() + first;
      for (int i = 0; i < kSpread; ++i) sum += weights[i] * node[i];
    } else {
      for (int i = 0; i < kSpread; ++i) sum += weights[i] * g[std::abs(first + i)];
    }
    return sum;
  }
  /// d energy / d T_j.
  static Eigen::ArrayXd energy_weights(double q, Eigen::Index nodes);

 private:
  static constexpr int kSpread = 10;
  // First of ten nodes around s, and their weights.
  static int lagrange(double s, double* weights) {
    // 1/((-1)^(9-i) i! (9-i)!)
    static constexpr double kScale[kSpread] = {-1.0 / 362880, 1.0 / 40320, -1.0 / 10080, 1.0 / 4320,
                                               -1.0 / 2880,   1.0 / 2880,  -1.0 / 4320,  1.0 / 10080,
                                               -1.0 / 40320,  1.0 / 362880};
    const double x = s * kNodesPerLag;
    const int first = int(x) - (kSpread / 2 - 1);
    const double t = x - first;
    double below[kSpread], above = 1;
    below[0] = 1;
    for (int i = 1; i < kSpread; ++i) below[i] = below[i - 1] * (t - (i - 1));
    for (int i = kSpread - 1; i >= 0; --i) {
      weights[i] = kScale[i] * below[i] * above;
      above *= t - i;
    }
    return first;
  }

  Eigen::ArrayXd values_;
};

}  // namespace aberfit
