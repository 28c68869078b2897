#pragma once
#include <Eigen/Core>
#include <complex>
#include <memory>

#include "aberfit/roughness/fourier_transform.h"

namespace aberfit::internal {

/// Hankel transform of order 0 between points that are even in the logarithm, where it is a convolution (A.
/// Talman, J. Comput. Phys. 29 (1978) 35; A. Hamilton, MNRAS 312 (2000) 257):
///   y_m = y F(y), y F(y) = 2 pi int x f(x) J0(2 pi x y) y dx, from values x_k f(x_k).
/// A logarithmic step must change the argument of J0 by less than 2 rad.
class LogHankel {
 public:
  /// Points of x from `low` to `high` inclusive, and of y from about `low_y` to `high_y`. turn: largest
  /// change of the argument of J0 over the last step, at x = high and y = high_y [rad].
  LogHankel(double low, double high, double low_y, double high_y, double turn);

  double step() const { return step_; }  ///< of ln x and ln y
  Eigen::ArrayXd x() const { return points(high_, count_x_); }
  Eigen::ArrayXd y() const { return points(high_y_, count_y_); }
  /// Replaces x f(x) at x() by y F(y) at y().
  void operator()(Eigen::ArrayXcd* values) const;

 private:
  Eigen::ArrayXd points(double high, Eigen::Index count) const;

  double high_, high_y_, step_ = 0;
  Eigen::Index count_x_ = 0, count_y_ = 0;
  Eigen::ArrayXcd kernel_;  // over frequency; longer than x and y, with room for the wrap-around of J0
  std::unique_ptr<FourierTransform> transform_;
};

}  // namespace aberfit::internal
