#pragma once
#include <functional>

namespace aberfit {

/// Relative error of a root that rounding leaves.
inline constexpr double kRootToRounding = 0x1p-49;

/// Root of f between a and b to a relative `tolerance` of at least 2^-50. fa and fb are the values of f
/// there, of opposite signs or one of them 0. (Alefeld, Potra and Shi 1995, algorithm 748, by Boost.)
double root_between(const std::function<double(double)>& f, double a, double b, double fa, double fb,
                    double tolerance = kRootToRounding);

/// The first point from `from` on at which f is no longer above zero; f_from = f(from) > 0. Searches in steps
/// of `step`, whose sign is the direction; shorter dips may be missed. NaN if |x| would exceed `limit`.
double first_crossing(const std::function<double(double)>& f, double from, double f_from, double step,
                      double limit, double tolerance = kRootToRounding);

}  // namespace aberfit
