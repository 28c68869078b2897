#pragma once
#include <Eigen/Core>
#include <optional>

#include "aberfit/method/attempt.h"

namespace aberfit::internal {

/// A start for a fit by waves: white coordinates near `draw` whose light is `begun.mismatch` tolerances away.
struct RayStart {
  Eigen::VectorXd white;
  RayApproach begun;
};

/// The start that fits by rays lead to (output space mapping: Bandler et al., Space mapping: the state of the
/// art, IEEE Trans. Microwave Theory Tech. 52, 2004, sec. V). Each meets targets that are shifted by what
/// rays and light differ by at the surface of the one before, the first by what their theories do. Draws are
/// 100 to 600 tolerances away, the first fit comes to 5 to 15, three or four to 1 to 5, each for less than
/// one step of the fit by waves. What is nearest is kept; nothing where the grid has no pattern of it, or
/// rays lead no nearer than a draw's first steps do.
/// met_within: of Workbench.
std::optional<RayStart> approach_by_rays(const FitCase& of, const FitPlan& plan, double met_within,
                                         const FitProblem& waves, const Eigen::VectorXd& draw);

}  // namespace aberfit::internal
