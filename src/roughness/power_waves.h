#pragma once
#include <array>
#include <vector>

namespace aberfit::internal {

/// A stretch of the band on which S is a power of f. There int S f J0(k f) df has an antiderivative whose
/// asymptotic series needs no nodes: with J0(t) = Re sqrt(2/(pi t)) exp(i (t - pi/4)) sum h_n t^-n (DLMF
/// 10.17.5) and q = 1/2 - exponent, int exp(i t) t^q sum h_n t^-n dt = exp(i t) t^q sum a_n t^-n,
/// i a_n + (q - n + 1) a_(n-1) = h_n.
class PowerStretch {
 public:
  static constexpr int kTerms = 25;

  PowerStretch(double f_min, double f_max, double exponent);
  double f_min() const { return f_min_; }
  double f_max() const { return f_max_; }
  /// Argument k f from which the series has converged to 1e-15; may be infinite.
  double smallest() const { return smallest_; }
  /// a_n without i: it is real for odd and imaginary for even n.
  const std::array<double, kTerms>& series() const { return a_; }

 private:
  double f_min_, f_max_, smallest_;
  std::array<double, kTerms> a_;
};

/// 2 pi int S J0(2 pi f r) f df over runs [a, b] of stretches, one wave for every end of a run and one for
/// two runs that meet; plus sums of weight J0(2 pi f r).
class PowerWaves {
 public:
  /// 2 pi r is at least `k` [rad/m].
  explicit PowerWaves(double k) : k_(k) {}
  /// Ascending. psd_a, psd_b: S at the ends [m^4].
  void add(const PowerStretch& stretch, double a, double psd_a, double b, double psd_b);
  /// Whether nodes at f may be added: 2 pi r f is at least 18, from where the Hankel amplitudes' series is
  /// exact to rounding.
  bool carries(double f) const { return k_ * f >= 18; }
  void add_node(double f, double weight);
  /// Arranges what was added; terms that stay below 1e-17 of `scale` [m^2] are left out.
  void arrange(double scale);
  double operator()(double r) const;

 private:
  struct Wave {
    double f;
    std::array<double, PowerStretch::kTerms + 1> series;  // of k_/(2 pi r)
  };
  struct Set {
    std::vector<Wave> waves;
    std::vector<double> data;  // of wave_sum
    std::vector<int> pairs;
    void arrange(double scale);
  };
  void add_end(const PowerStretch& stretch, double f, double amplitude);

  double k_;
  Set ends_, nodes_;
};

}  // namespace aberfit::internal
