#pragma once

namespace aberfit::internal {

/// A number with its derivative along one direction: what the templated physics needs to be differentiated
/// forwards, and no more.
struct Dual {
  double value = 0, derivative = 0;
};

inline Dual operator+(const Dual& a, const Dual& b) {
  return {a.value + b.value, a.derivative + b.derivative};
}
inline Dual operator-(const Dual& a, const Dual& b) {
  return {a.value - b.value, a.derivative - b.derivative};
}
inline Dual operator*(const Dual& a, const Dual& b) {
  return {a.value * b.value, a.derivative * b.value + a.value * b.derivative};
}
inline Dual operator-(double a, const Dual& b) { return {a - b.value, -b.derivative}; }
inline Dual operator/(double a, const Dual& b) {
  const double quotient = a / b.value;
  return {quotient, -quotient / b.value * b.derivative};
}

}  // namespace aberfit::internal
