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

/// Legendre polynomials P_0 .. P_(count-1) at t in [-1, 1], (point, l); count >= 1. DLMF 18.9.1 (Bonnet).
Eigen::ArrayXXd legendre_polynomials(const Eigen::ArrayXd& t, int count);

/// The n-point rule on [-1, 1] with n Legendre polynomials at its nodes, (node, l).
struct LegendreRule {
  Eigen::ArrayXd nodes, weights;
  Eigen::ArrayXXd polynomials;
};
LegendreRule legendre_rule(int n);

}  // namespace aberfit
