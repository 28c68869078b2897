#pragma once
#include <ceres/gradient_checker.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "../../src/fit/focus_residuals.h"

namespace aberfit {

/// Largest difference between the Jacobian of the residual and its Ridders differences, over the largest
/// derivative. step: of the white coordinates.
inline double gradient_error(const internal::WhiteResiduals& residual, const Eigen::VectorXd& white,
                             double step) {
  ceres::NumericDiffOptions how;
  how.ridders_relative_initial_step_size = step;  // also Ceres' smallest absolute step
  const std::vector<const ceres::Manifold*>* no_manifolds = nullptr;
  ceres::GradientChecker checker(&residual, no_manifolds, how);
  std::vector<const double*> blocks;
  Eigen::Index at = 0;
  for (const int length : residual.parameter_block_sizes()) {
    blocks.push_back(white.data() + at);
    at += length;
  }
  ceres::GradientChecker::ProbeResults results;
  checker.Probe(blocks.data(), 1e-3, &results);
  EXPECT_TRUE(results.return_value);
  double largest = 0, error = 0;
  for (std::size_t b = 0; b < results.jacobians.size(); ++b) {
    largest = std::max(largest, results.jacobians[b].cwiseAbs().maxCoeff());
    error = std::max(error, (results.jacobians[b] - results.numeric_jacobians[b]).cwiseAbs().maxCoeff());
  }
  EXPECT_GT(largest, 0);
  return error / largest;
}

}  // namespace aberfit
