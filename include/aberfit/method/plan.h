#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <memory>

#include "aberfit/method/task.h"
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

/// Share of the height variance, piston and tilt left out, below which terms are said to be truncated.
inline constexpr double kCapturedHeight = 0.99;

/// The order of the Zernikes that carry a band up to `frequency` [cycles/m] on a disc of `radius` [m]:
/// law::kOrderBeyondCut times 2 pi R f, rounded up, at least 2.
int order_to_carry(double radius, double frequency);

/// The order that carries a whole roughness: order_to_carry where all but law::kSlopeBeyondTerms of its slope
/// variance lies below, which is f_max of a band, and the end of a Gaussian PSD, which has no other.
int order_of_band(const RadialPsd& psd, double radius);

/// The largest order that is chosen by default: 5,148 terms, whose prior takes seconds.
inline constexpr int kLargestDefaultOrder = 100;

/// The terms; absent orders and frequencies are chosen from the PSD. `captured` as in TermPlan. Throws
/// FieldError for terms that cannot be had.
TermSet make_terms(const Task& task, const Groundwork& ground, const TermsSpec& asked, double* captured);
/// The same with their prior, which costs more the more terms there are.
TermPlan plan_terms(const Task& task, const Groundwork& ground, const TermsSpec& asked);

/// What the guides of a fit by waves are held to, in their tolerances, where its verdict is in doubt: waves
/// have no more rays to take.
inline constexpr double kGuidesInDoubt = 0.6;

/// What a fit does where it stays above the tolerances (StallWatch).
enum class OnStall {
  kGoOn,    ///< as long as it has iterations
  kGiveUp,  ///< early: there are other sets of terms, or more rays, to try
  kEnd,     ///< patiently, with what it has come to: the study has no other set
};

/// What a run has decided about one fit: the task says what is wanted, the plan how it is tried.
struct FitPlan {
  std::shared_ptr<const TermPlan> terms;
  PupilOptions pupil;           ///< rays; waves have a grid that their light decides
  bool automatic_rays = false;  ///< more of them until fresh ones say the same
  double coarsening = 1;        ///< of the grid that waves need (wave_pitch)
  int starts = 1;               ///< tries from different draws; by waves until one is equivalent
  int first_start = 0;          ///< the draw that is tried first
  int most_iterations = 100;
  Eigen::VectorXd warm;  ///< white coordinates to start from instead of a draw
  Eigen::VectorXd seen;  ///< by waves: those of a surface that was judged and is not equivalent
  OnStall on_stall = OnStall::kGoOn;
  double guides_within = 1;  ///< by waves: of their tolerances, before the fit ends
};

/// The fit that a task with explicit terms asks for.
FitPlan make_plan(const Task& task, std::shared_ptr<const TermPlan> terms);

/// What a fit used where the task leaves it open: written into the resolved study, it gives the same fit.
struct ChosenByFit {
  TermsSpec terms;
  std::int64_t rays = 0;  ///< of the first look
  int starts = 1;
  bool second_look = false;  ///< FitSpec
};

}  // namespace aberfit
