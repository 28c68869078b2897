#pragma once

namespace aberfit::internal {

/// J_0(x) .. J_top(x) into values[0..top], x > 0. One recurrence goes upward for x > top, and otherwise
/// downward from beyond the turning point (Miller). It keeps full relative accuracy down to underflow.
void bessel_j_orders(double x, int top, double* values);

}  // namespace aberfit::internal
