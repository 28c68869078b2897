#pragma once
#include <functional>

namespace aberfit {

/// Relative distance of two doubles that rounding leaves of a root.
inline constexpr double kRootToRounding = 0x1p-49;

/// Root of f between a and b, where it has the values fa and fb of opposite signs or one of them 0, to a
/// relative `tolerance` of at least 2^-50 (Alefeld, Potra and Shi 1995, algorithm 748, by Boost).
double root_between(const std::function<double(double)>& f, double a, double b, double fa, double fb,
                    double tolerance = kRootToRounding);

/// The first place from `from` on, looked for in steps of `step`, at which f, there `f_from` > 0, is not
/// above zero any more; |step| decides what is overlooked, its sign the direction. NaN where it lies at an
/// |x| above `limit`.
double first_crossing(const std::function<double(double)>& f, double from, double f_from, double step,
                      double limit, double tolerance = kRootToRounding);

}  // namespace aberfit
