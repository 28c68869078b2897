#pragma once
#include <Eigen/Core>

#include "aberfit/specify/solve.h"

namespace aberfit {

/// Encircled energy in the focus by generalised Harvey-Shack, as fractions at each radius.
struct BudgetLight {
  Eigen::ArrayXd radius;    ///< [m], ascending in equal factors
  Eigen::ArrayXd perfect;   ///< mirror without roughness
  Eigen::ArrayXd study;     ///< PSD of the study
  Eigen::ArrayXd solution;  ///< PSD of the first solution; empty if there is none
};

/// Radii reach from a tenth of the smallest to three times the largest budgeted radius, and at least over 10
/// to 95 % encircled energy of the study. Empty if the specification is by rays.
BudgetLight budget_light(const TaskAt& task_at, const Specification& spec, int threads);

/// Returns the radius [m] that a budget of an encircled energy in the focus limits; NaN for other budgets.
double budgeted_radius(const Budget& budget, double focal_length);

}  // namespace aberfit
