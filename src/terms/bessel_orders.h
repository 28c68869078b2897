#pragma once

namespace aberfit::internal {

/// J_0(x) .. J_top(x) into values[0..top], x > 0. One recurrence: upward for x > top, else downward from
/// beyond the turning point (Miller), which keeps full relative accuracy down to underflow.
void bessel_j_orders(double x, int top, double* values);

}  // namespace aberfit::internal
