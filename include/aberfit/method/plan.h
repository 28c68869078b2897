#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <memory>

#include "aberfit/method/task.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

struct Groundwork;

/// Terms, and their statistics by the specification.
struct TermPlan {
  TermsSpec asked;  ///< the request without automatic entries
  TermSet terms;
  CoefficientPrior prior;
  double captured = 0;  ///< fraction of the height variance that they can carry, without piston and tilt
};

/// The order of the Zernikes that carry a band up to `frequency` [cycles/m] on a disc of `radius` [m]:
/// law::kOrderBeyondCut times 2 pi R f, rounded up, at least 2.
int order_to_carry(double radius, double frequency);
/// Returns where the terms of a band end [cycles/m]: its upper end, or, for a band without one, the frequency
/// above which law::kSlopeBeyondTerms of its slope variance lies.
double band_end(const RadialPsd& band);

/// The terms; absent orders and frequencies are chosen from the PSD. `captured`: as in TermPlan. Throws
/// FieldError for terms that are not possible.
TermSet make_terms(const Task& task, const Groundwork& ground, const TermsSpec& asked, double* captured);
/// The same with their prior, whose cost grows with the number of terms.
TermPlan plan_terms(const Task& task, const Groundwork& ground, const TermsSpec& asked);

/// The decisions of a run about one fit. The task holds what is wanted; the plan holds how it is tried.
struct FitPlan {
  std::shared_ptr<const TermPlan> terms;
  PupilOptions pupil;           ///< rays; the grid of waves follows from their targets instead
  bool automatic_rays = false;  ///< the number of rays grows until fresh rays agree
  double coarsening = 1;        ///< pitch of the grid of waves over wave_pitch
  int start = 0;                ///< index of the seeded random start
  int most_iterations = 100;
  int set = 1, most_sets = 0;  ///< number of this set of terms, and of all at most (0: unknown)
  Eigen::VectorXd warm;        ///< white coordinates to start from instead of a random start
};

/// The fit of these terms as the task specifies it, from its first random start.
FitPlan make_plan(const Task& task, std::shared_ptr<const TermPlan> terms);

/// The values that a fit used where the task leaves them open. Used in a study, they give the same fit.
struct ChosenByFit {
  TermsSpec terms;
  std::int64_t rays = 0;
  int starts = 1;  ///< number of starts tried
};

}  // namespace aberfit
