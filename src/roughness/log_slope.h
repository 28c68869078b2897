#pragma once
#include <vector>

#include "aberfit/roughness/psd.h"

namespace aberfit::internal {

/// d ln S/dp at a frequency inside the band, of one part of a PSD: a sum of the few functions that the
/// derivatives of all models are made of.
struct LogSlope {
  double constant = 0;
  double log_f = 0;        ///< times ln f
  double log_knee = 0;     ///< times ln(1 + (B f)^2)
  double knee = 0;         ///< times (B f)^2/(1 + (B f)^2)
  double square = 0;       ///< times f^2 [m^2]
  double correlation = 0;  ///< B [m]
  /// Times what falls from 1 at `middle` to 0 at `left` and `right`, straight over ln f: a row of a table. At
  /// the table's ends one of the sides is empty.
  double hat = 0;
  double left = 0, middle = 0, right = 0;  ///< [cycles/m]

  double operator()(double f) const;
  bool is_constant() const;
};

/// 2 pi int_a^b f^(power + 1) S q df of a PSD of one part, as radial_moment; it exists where that does with a
/// power a little away.
double slope_moment(const RadialPsd& psd, const LogSlope& slope, double power, double a, double b);

/// int_L^H w^m exp(p w) dw, m 0 or 1, without cancellation for p near 0; ends may be infinite where it
/// exists.
double exponential_integral(int m, double p, double low, double high);

}  // namespace aberfit::internal
