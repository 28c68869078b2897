#pragma once

namespace aberfit {

inline double square(double x) { return x * x; }

}  // namespace aberfit
