#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

/// A smooth even function of the distance from the axis, as a polynomial in its square. It replaces the
/// formula of a conic or of even powers of the radius in a phase, which takes three times as long.
class EvenPolynomial {
 public:
  /// The polynomial of the lowest even degree in the square, 2 to 24, with an error of at most `error`
  /// between its Chebyshev points. Empty if there is none. radius: of the disc [m].
  static std::optional<EvenPolynomial> of(const std::function<double(double rho)>& function, double radius,
                                          double error);

  /// Adds its values at n points of the disc to `result`.
  void add(const double* x, const double* y, int n, double* result,
           InstructionSet set = best_instruction_set()) const;
  int degree() const { return int(coefficient_.size()) - 1; }

 private:
  double value(double square) const;

  double scale_ = 0;                 // factor of the square: 2 at the rim
  std::vector<double> coefficient_;  // of powers of scale_ rho^2 - 1
};

}  // namespace aberfit::internal
