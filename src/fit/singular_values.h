#pragma once
#include <Eigen/Core>

namespace aberfit {

/// left diag(values) right^T of a square matrix, values descending.
struct SingularValues {
  Eigen::MatrixXd left, right;
  Eigen::VectorXd values;
};

/// By divide and conquer (Gu & Eisenstat 1995): error of a value about 1e-15 of the largest one. A file of
/// its own because Eigen's templates for it take a minute to compile.
SingularValues singular_values(const Eigen::MatrixXd& matrix);

}  // namespace aberfit
