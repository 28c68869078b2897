#pragma once
#include "aberfit/theory/scatter_function.h"

namespace aberfit {

/// The ABg model BSDF = a / (b + |sin theta - sin theta_0|^g) at normal incidence, theta_0 = 0, as in
/// OpticStudio, FRED, ASAP and LightTools (FORMATS). a [1/sr] >= 0, b > 0 and g >= 0 refer to sines. `g` is
/// the exponent.
struct AbgModel {
  double a = 0, b = 0, g = 0;

  double bsdf(double theta) const;  ///< [1/sr]
  /// Fraction scattered to within theta [rad], 0 <= theta <= pi/2: 2 pi int a s / (b + s^g) ds up to s =
  /// sin(theta). Its value at pi/2 is the TIS. Relative error below 1e-10.
  double within(double theta) const;
};

struct AbgOptions {
  double theta_min = 0, theta_max = 0;  ///< range [rad]; both 0: automatic, see fit_abg
  /// An automatic range ends where the function falls below this fraction of its maximum in the band.
  double floor = 1e-4;
  /// Least b; OpticStudio accepts only values above 1e-12. A smaller one, where the other program allows it,
  /// describes a knee at a smaller sine, b^(1/g).
  double least_b = 1.01e-12;
};

/// Largest relative error of an ABg model that may replace the scatter function. 1 is a factor of two, the
/// usual margin of stray-light estimates for each scatter model.
inline constexpr double kUsableAbg = 1;

/// The ABg model nearest to a scatter function over a range of angles, and its error.
struct AbgFit {
  bool found = false;                   ///< false where nothing scatters
  AbgModel model;                       ///< `a` is such that the mean log ratio is 0
  double theta_min = 0, theta_max = 0;  ///< range it was fitted over [rad]
  /// exp(max |log(model/function)|) - 1 and exp(rms log ratio) - 1 at 400 log-spaced sines of the range.
  double largest_error = 0, rms_error = 0;
  double tis = 0;             ///< TIS of the model, over the hemisphere
  double light_in_range = 0;  ///< fraction of the total energy that the scatter function sends into the range
  double model_in_range = 0;  ///< the same for the model
  bool at_least_b = false;    ///< b is at its bound `least_b`; the function may go on rising below b^(1/g)

  /// True if the model may replace the function: found, and its error nowhere exceeds `kUsableAbg`.
  bool describes() const { return found && largest_error <= kUsableAbg; }
};

/// Least squares of log BSDF over the log of the sine. An automatic range starts at the sine within which
/// 1/1000 of the scattered energy lies, or at the lowest frequency of the band if that is higher. It ends at
/// the first of these: 90 degrees, the highest frequency, and the sine beyond which the function stays below
/// `floor` of its largest value in the range. A band edge counts only if the function changes there by more
/// than a factor 1.5; at large g it does not show. The exponent is kept in [0, 10]. Takes tens of
/// milliseconds. `found` is false, all else 0, for a surface that does not scatter. Throws
/// std::invalid_argument for a given range that is not 0 < theta_min < theta_max <= pi/2 or in which the
/// function is not positive.
AbgFit fit_abg(const ScatterFunction& scatter, const AbgOptions& options = {});

}  // namespace aberfit
