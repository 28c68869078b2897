#pragma once
#include <functional>
#include <vector>

#include "aberfit/roughness/psd.h"

namespace aberfit::internal {

/// d ln S/dp at a frequency inside the band, for one part of a PSD. It is a sum of the few functions that
/// occur in the derivatives of all models.
struct LogSlope {
  double constant = 0;
  double log_f = 0;        ///< factor of ln f
  double log_knee = 0;     ///< factor of ln(1 + (B f)^2)
  double knee = 0;         ///< factor of (B f)^2/(1 + (B f)^2)
  double square = 0;       ///< factor of f^2 [m^2]
  double correlation = 0;  ///< B [m]
  /// Factor of a function linear in ln f that falls from 1 at `middle` to 0 at `left` and `right`: a row of a
  /// table. At each end of the table one side does not exist.
  double hat = 0;
  double left = 0, middle = 0, right = 0;  ///< [cycles/m]

  /// Any other function of f; 0 at f = 0, and where S is a power at high frequency.
  std::function<double(double)> other = nullptr;

  double operator()(double f) const;
  bool is_constant() const;
};

/// 2 pi int_a^b f^(power + 1) S q df for a PSD of one part, like radial_moment. It exists if radial_moment
/// exists for slightly larger and smaller powers.
double slope_moment(const RadialPsd& psd, const LogSlope& slope, double power, double a, double b);

/// int_L^H w^m exp(p w) dw, m = 0 or 1, without cancellation near p = 0. Ends may be infinite if it exists.
double exponential_integral(int m, double p, double low, double high);

}  // namespace aberfit::internal
