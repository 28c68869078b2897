#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

/// A smooth function of the distance from the axis, even in it, as a polynomial in its square: what a conic
/// or even powers of the radius make of a phase. Targets of a conic by means over azimuth take a third of the
/// time that they take with its formula.
class EvenPolynomial {
 public:
  /// Of the lowest even degree in the square, 2 to 24, that is `error` or less off between the Chebyshev
  /// points that it goes through. Nothing where none is, or where the function is not finite. radius: where
  /// the disc ends [m].
  static std::optional<EvenPolynomial> of(const std::function<double(double rho)>& function, double radius,
                                          double error);

  /// Adds its values at n points of the disc to `result`.
  void add(const double* x, const double* y, int n, double* result,
           InstructionSet set = best_instruction_set()) const;
  int degree() const { return int(coefficient_.size()) - 1; }

 private:
  double value(double square) const;

  double scale_ = 0;                 // of the square: 2 at the rim
  std::vector<double> coefficient_;  // of powers of scale_ rho^2 - 1
};

}  // namespace aberfit::internal
