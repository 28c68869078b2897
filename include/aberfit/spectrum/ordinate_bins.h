#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace aberfit {

/// Ordinates of a discrete Fourier transform of rows x cols samples; rows = 1 for a profile. Index (j, i) of
/// the transform is the frequency (signed_index(i, cols) step_x, signed_index(j, rows) step_y).
struct OrdinateGrid {
  int rows = 1, cols = 0;
  double step_x = 0, step_y = 0;  ///< [cycles/m]; step_y is 0 for a profile
  /// From this frequency on, too little of a wave is left to restore its height [cycles/m].
  double lost_from = std::numeric_limits<double>::infinity();

  bool profile() const { return rows == 1; }
  int size() const { return rows * cols; }
  static int signed_index(int i, int n) { return 2 * i < n ? i : i - n; }
  static int wrapped(int k, int n) { return ((k % n) + n) % n; }
  int index(int k, int l) const { return wrapped(l, rows) * cols + wrapped(k, cols); }
  int k(int index) const { return signed_index(index % cols, cols); }
  int l(int index) const { return signed_index(index / cols, rows); }
  int conjugate(int at) const { return index(-k(at), -l(at)); }
  double frequency(int at) const { return std::hypot(k(at) * step_x, l(at) * step_y); }
  /// Return the finest step, the coarsest step and the lower Nyquist frequency of the two axes [cycles/m].
  double resolution() const { return profile() ? step_x : std::min(step_x, step_y); }
  double coarse_step() const { return std::max(step_x, step_y); }
  double nyquist() const {
    return profile() ? 0.5 * cols * step_x : 0.5 * std::min(cols * step_x, rows * step_y);
  }
  double top() const { return std::min(nyquist(), lost_from); }  ///< upper end of the bins
};

/// Logarithmic bins of ordinates; conjugates are in the same bin, zero and frequencies from `top` on in none.
struct OrdinateBins {
  std::vector<int> of;  ///< bin of every ordinate of the grid; -1: none
  Eigen::ArrayXd frequency, low, high;
  Eigen::ArrayXd count;  ///< number of ordinates, each conjugate pair counted once

  Eigen::Index size() const { return count.size(); }
  /// Returns the mean over each bin of a value per ordinate.
  Eigen::ArrayXd mean(const Eigen::ArrayXd& ordinate) const;
};

/// left_out: ordinates to exclude, symmetric under conjugation; empty: none. They do not change the bin
/// edges, but a bin without remaining ordinates is dropped.
OrdinateBins logarithmic_bins(const OrdinateGrid& grid, int bins_per_decade,
                              const std::vector<char>& left_out);

}  // namespace aberfit
