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

/// Terms, and what the specification says of them.
struct TermPlan {
  TermsSpec asked;  ///< what they were made from: nothing automatic
  TermSet terms;
  CoefficientPrior prior;
  double captured = 0;  ///< share of the height variance that they can carry, piston and tilt left out
};

/// The order of the Zernikes that carry a band up to `frequency` [cycles/m] on a disc of `radius` [m]:
/// law::kOrderBeyondCut times 2 pi R f, rounded up, at least 2.
int order_to_carry(double radius, double frequency);
/// Where the terms of a band end [cycles/m]: its upper end, or the frequency above which a band without one
/// has law::kSlopeBeyondTerms of its slope variance.
double band_end(const RadialPsd& band);

/// The terms; absent orders and frequencies are chosen from the PSD. `captured` as in TermPlan. Throws
/// FieldError for terms that cannot be had.
TermSet make_terms(const Task& task, const Groundwork& ground, const TermsSpec& asked, double* captured);
/// The same with their prior, which costs more the more terms there are.
TermPlan plan_terms(const Task& task, const Groundwork& ground, const TermsSpec& asked);

/// What a run has decided about one fit: the task says what is wanted, the plan how it is tried.
struct FitPlan {
  std::shared_ptr<const TermPlan> terms;
  PupilOptions pupil;           ///< rays; waves have a grid that their light decides
  bool automatic_rays = false;  ///< more of them until fresh ones say the same
  double coarsening = 1;        ///< of the grid that waves need (wave_pitch)
  int start = 0;                ///< which of the seeded draws it begins with
  int most_iterations = 100;
  int set = 1, most_sets = 0;  ///< which set of terms this is, of at most how many (0: not known), for people
  Eigen::VectorXd warm;        ///< white coordinates to start from instead of a draw
};

/// The fit of these terms, as the task asks for it, from its first draw.
FitPlan make_plan(const Task& task, std::shared_ptr<const TermPlan> terms);

/// What a fit used where the task leaves it open: written into the resolved study, it gives the same fit.
struct ChosenByFit {
  TermsSpec terms;
  std::int64_t rays = 0;
  int starts = 1;  ///< that were tried
};

}  // namespace aberfit
