#pragma once
#include <Eigen/LU>
#include <boost/math/special_functions/digamma.hpp>
#include <boost/math/special_functions/trigamma.hpp>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit::test {

/// Line through log psd over log f, psd ~ level (f / 1 per m)^-exponent, from bins with `frequency` in
/// [f_min, f_max], weighted by dof, without the bias of the logarithm, psi(dof/2) - log(dof/2).
struct PsdSlope {
  double exponent = 0, exponent_std = 0;
  double level = 0;  ///< PSD at 1 cycle/m [m^3 or m^4]
};
inline PsdSlope psd_slope(const PsdEstimate& estimate, double f_min, double f_max) {
  std::vector<Eigen::Index> used;
  for (Eigen::Index b = 0; b < estimate.psd.size(); ++b)
    if (estimate.frequency[b] >= f_min && estimate.frequency[b] <= f_max && estimate.psd[b] > 0)
      used.push_back(b);
  if (used.size() < 2) throw std::invalid_argument("a PSD slope needs at least two bins inside its band");
  const Eigen::Index n = Eigen::Index(used.size());
  Eigen::MatrixX2d design(n, 2);
  Eigen::VectorXd level(n), weight(n), deviation(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index b = used[std::size_t(i)];
    const double half = 0.5 * estimate.dof[b];
    design(i, 0) = 1, design(i, 1) = std::log(estimate.frequency[b]);
    // E log(chi^2_dof/dof) = psi(dof/2) - log(dof/2), variance psi'(dof/2).
    level[i] = std::log(estimate.psd[b]) - (boost::math::digamma(half) - std::log(half));
    weight[i] = estimate.dof[b];
    deviation[i] = std::sqrt(boost::math::trigamma(half) / estimate.relative_covariance(b, b));
  }
  const Eigen::Matrix2d normal = design.transpose() * weight.asDiagonal() * design;
  const Eigen::Matrix2d inverse = normal.inverse();
  const Eigen::Matrix<double, 2, Eigen::Dynamic> solver = inverse * design.transpose() * weight.asDiagonal();
  const Eigen::Vector2d line = solver * level;
  const Eigen::MatrixXd covariance = deviation.asDiagonal() *
                                     Eigen::MatrixXd(estimate.relative_covariance(used, used)) *
                                     deviation.asDiagonal();
  const Eigen::Matrix2d uncertainty = solver * covariance * solver.transpose();
  return {-line[1], std::sqrt(uncertainty(1, 1)), std::exp(line[0])};
}

}  // namespace aberfit::test
