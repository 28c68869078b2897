#pragma once

namespace aberfit::internal {

inline double square(double x) { return x * x; }

}  // namespace aberfit::internal
