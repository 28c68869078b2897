#pragma once
#include "aberfit/theory/scatter_function.h"

namespace aberfit {

/// BSDF = a / (b + |sin theta - sin theta_0|^g) at normal incidence, theta_0 = 0: the ABg model that
/// OpticStudio, FRED, ASAP and LightTools take (FORMATS). a [1/sr] >= 0, b > 0 and g >= 0 have the sines'
/// units. `g` is the exponent, not the roughness.
struct AbgModel {
  double a = 0, b = 0, g = 0;

  double bsdf(double theta) const;  ///< [1/sr]
  /// Light scattered to within theta [rad], 0 <= theta <= pi/2: 2 pi int a s / (b + s^g) ds up to s =
  /// sin(theta); its value at pi/2 is the TIS. Relative error below 1e-10.
  double within(double theta) const;
};

struct AbgOptions {
  double theta_min = 0, theta_max = 0;  ///< range [rad]; both 0: chosen, see fit_abg
  /// Of the function's maximum in the band, down to which an automatic range goes.
  double floor = 1e-4;
  /// Least b; OpticStudio takes only values above 1e-12. A smaller one, where the other program allows it,
  /// describes a knee at a smaller sine, b^(1/g).
  double least_b = 1.01e-12;
};

/// Error of an ABg model, at the angle where it is largest, up to which it may stand for the scatter
/// function: a factor of two, which is what estimates of stray light leave as margin for each scatter model.
/// A model beyond takes all of that margin by its form alone, where the table costs nothing.
inline constexpr double kUsableAbg = 1;

/// The ABg model nearest to a scatter function over a range of angles, and what it misses.
struct AbgFit {
  bool found = false;                   ///< false where there is no light to fit
  AbgModel model;                       ///< with a such that the mean log ratio is 0
  double theta_min = 0, theta_max = 0;  ///< range it was fitted over [rad]
  /// exp(max |log(model/function)|) - 1 and exp(rms log ratio) - 1 at 400 log-spaced sines of the range.
  double largest_error = 0, rms_error = 0;
  double tis = 0;             ///< of the model, over the hemisphere
  double light_in_range = 0;  ///< of the scatter function, share of all light between the two angles
  double model_in_range = 0;  ///< of the model between them
  bool at_least_b = false;    ///< b rests on `least_b`: the function may go on rising below b^(1/g)

  /// Whether the model may stand for the function: found, and nowhere off by more than `kUsableAbg`.
  bool describes() const { return found && largest_error <= kUsableAbg; }
};

/// Least squares of log BSDF over the log of the sine. An automatic range starts where a thousandth of the
/// scattered light lies within, or at the lowest frequency of the band if that is higher, and ends at 90
/// degrees, at the highest frequency, or where the function falls below `floor` of its largest value in the
/// range for good, whichever comes first. Band edges count where the function steps by more than a factor
/// 1.5 there: at large g nothing is seen of them. The exponent is kept in [0, 10]. Deterministic; costs some
/// tens of milliseconds. `found` is false, all else 0, of a surface that does not scatter.
/// Throws std::invalid_argument for a given range that is not 0 < theta_min < theta_max <= pi/2 or in which
/// the function is not positive.
AbgFit fit_abg(const ScatterFunction& scatter, const AbgOptions& options = {});

}  // namespace aberfit
