#pragma once
#include <Eigen/Core>

namespace aberfit {

/// Nodes and weights of a one-dimensional rule; sum of weights = length of the interval.
struct Quadrature {
  Eigen::ArrayXd nodes;
  Eigen::ArrayXd weights;
};

/// n-point Gauss-Legendre rule on [a, b], nodes ascending; exact for polynomials of degree 2n - 1. n >= 1.
Quadrature gauss_legendre(int n, double a, double b);

}  // namespace aberfit
