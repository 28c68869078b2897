#pragma once
#include <array>
#include <vector>

namespace aberfit::internal {

/// A stretch of the band on which S is a power of f. The antiderivative of S f J0(k f) has an asymptotic
/// series there, which needs no nodes. With J0(t) = Re sqrt(2/(pi t)) exp(i (t - pi/4)) sum h_n t^-n (DLMF
/// 10.17.5) and q = 1/2 - exponent: int exp(i t) t^q sum h_n t^-n dt = exp(i t) t^q sum a_n t^-n, i a_n + (q
/// - n + 1) a_(n-1) = h_n.
class PowerStretch {
 public:
  static constexpr int kTerms = 25;

  PowerStretch(double f_min, double f_max, double exponent);
  double f_min() const { return f_min_; }
  double f_max() const { return f_max_; }
  /// Smallest argument k f at which the series converges to 1e-15; may be infinite.
  double smallest() const { return smallest_; }
  /// a_n without i; a_n is real for odd and imaginary for even n.
  const std::array<double, kTerms>& series() const { return a_; }

 private:
  double f_min_, f_max_, smallest_;
  std::array<double, kTerms> a_;
};

/// 2 pi int S J0(2 pi f r) f df over runs [a, b] of stretches, plus sums of weight J0(2 pi f r). Every end of
/// a run is one wave; two runs that meet share one.
class PowerWaves {
 public:
  /// 2 pi r must be at least `k` [rad/m].
  explicit PowerWaves(double k) : k_(k) {}
  /// Runs must be ascending. psd_a, psd_b: S at the ends [m^4].
  void add(const PowerStretch& stretch, double a, double psd_a, double b, double psd_b);
  /// Returns whether nodes at f are allowed: 2 pi r f must be at least 18, from where the series of the
  /// Hankel amplitudes is exact to rounding.
  bool carries(double f) const { return k_ * f >= 18; }
  void add_node(double f, double weight);
  /// Arranges the waves and omits terms that stay below 1e-17 of `scale` [m^2].
  void arrange(double scale);
  double operator()(double r) const;

 private:
  struct Wave {
    double f;
    std::array<double, PowerStretch::kTerms + 1> series;  // series in k_/(2 pi r)
  };
  struct Set {
    std::vector<Wave> waves;
    std::vector<double> data;  // input of wave_sum
    std::vector<int> pairs;
    void arrange(double scale);
  };
  void add_end(const PowerStretch& stretch, double f, double amplitude);

  double k_;
  Set ends_, nodes_;
};

}  // namespace aberfit::internal
