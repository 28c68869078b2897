#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

/// A smooth function on a disc as a polynomial in x and y: known aberrations are one, or nearly so, and a
/// polynomial of degree 6 takes a tenth of the time of a cubic interpolation in a table (of three low
/// Zernikes on a heptagon, tests/theory/disc_polynomial_test.cpp has the accuracy).
class DiscPolynomial {
 public:
  /// Of the lowest even degree from 4 on that is `error` or less off wherever it was looked at: at the points
  /// of the least-squares fit and at as many between them. Nothing where degree 16 does not suffice, or where
  /// the function is not finite.
  static std::optional<DiscPolynomial> of(const std::function<double(double, double)>& function,
                                          double radius, double error);

  /// Adds its values at n points of the disc to `result`.
  void add(const double* x, const double* y, int n, double* result,
           InstructionSet set = best_instruction_set()) const;
  int degree() const { return degree_; }

 private:
  DiscPolynomial(int degree, double radius) : degree_(degree), scale_(1 / radius) {}
  int degree_;
  double scale_;
  std::vector<double> coefficient_;  // of powers of x/radius and y/radius, in the order of Horner's rule
};

}  // namespace aberfit::internal
