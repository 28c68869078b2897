#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/method/run_context.h"
#include "aberfit/method/task.h"
#include "aberfit/specify/budget.h"

// Which roughness meets a budget: numbers of the PSD as unknowns, statistics of the theory (PHYSICS 5, 6) as
// functions of them, no fit and no draw.
namespace aberfit {

/// A number of a study that is looked for.
struct SolveUnknown {
  std::string pointer;  ///< in the study, "/roughness/psd/rms"
  double start = 0;     ///< the study's own, > 0 [its SI unit]
  Dimension dimension = Dimension::kNumber;
};

/// The task with its unknowns at `values`. Throws InputError where they are not allowed.
using TaskAt = std::function<Task(const std::vector<double>& values)>;

/// One budget at one place.
struct BudgetState {
  double value = 0;   ///< what is limited [m] or [rad]; infinite where the light is not within r = f
  double margin = 0;  ///< (limit - value)/limit for <=, (value - limit)/limit for >=: negative is violated
  /// d ln(value)/d ln(unknown), one for each unknown: exact (theory/psd_jacobian.h); of a number that the
  /// model of the PSD is made from by a formula central differences of 1e-3, error about 1e-6.
  std::vector<double> sensitivity;
};
/// All budgets at one place.
struct SolvePoint {
  std::vector<double> at;  ///< of each unknown [its SI unit]
  std::vector<BudgetState> budgets;
  std::size_t binding = 0;          ///< the budget of the least margin
  std::array<double, 2> bracket{};  ///< of a solution: the neighbouring steps it was found between
  bool holds_below = true;          ///< of a solution: budgets hold below it, else above
};
/// Where the search for one unknown ended.
struct RangeEnd {
  double value = 0;  ///< last that could be computed
  std::string why;
};

enum class SolveStatus {
  kNotRun,
  kSolved,
  kNoSolution,  ///< nowhere in the range do all budgets hold
  kUnbounded,   ///< they hold everywhere in it
};
std::string to_string(SolveStatus status);

struct SolveOptions {
  double step = 1.5;   ///< factor between neighbouring steps of the search: closer pairs of roots are one
  double decades = 4;  ///< how far the search goes either way of the start
  double contour_decades = 1;  ///< how far a contour goes either way in each unknown
  /// Share of mirrors of the specification that a budget has to hold for, in (0.5, 1); 0: it has to hold for
  /// their mean light.
  double confidence = 0;
};

/// Who uses how much of a budget, of a path with several contributors (contributors.h).
struct BudgetUse {
  std::string name;
  std::vector<double> alone;    ///< what the budgets limit with nothing but this [m], [rad] or [1]
  std::vector<double> without;  ///< with everything but this
};

/// The curve in two unknowns on which the strictest budget is met exactly.
struct Contour {
  std::vector<SolvePoint> points;  ///< in order along the curve
  bool is_closed = false;
  std::array<std::string, 2> ends;  ///< why it ends there
};

struct Specification {
  std::string title;
  SolveStatus status = SolveStatus::kNotRun;
  Theory theory = Theory::kGhs;
  double confidence = 0;    ///< as in SolveOptions
  double focal_length = 0;  ///< [m]
  std::vector<SolveUnknown> unknowns;
  std::vector<Budget> budgets;
  SolvePoint start;
  std::vector<SolvePoint> solutions;       ///< of the first unknown, nearest to the start first
  SolvePoint nearest;                      ///< least violated (kNoSolution), least margin (kUnbounded)
  std::vector<std::vector<double>> alone;  ///< of each budget as if it were the only one, nearest first
  std::vector<BudgetState> perfect;        ///< of the mirror without roughness
  std::array<RangeEnd, 2> range;           ///< of the first unknown
  std::string reason;                      ///< why there is no solution, or no bound
  Contour contour;                         ///< of two unknowns
  std::vector<BudgetUse> uses;             ///< at the first solution; empty of a mirror alone
  int evaluations = 0;
  double seconds = 0;
  Warnings warnings;
};

/// Solves for the first unknown with the others at their starts: geometric steps both ways from the start
/// until a value is refused, the theory ends, nothing changes any more or options.decades are reached; each
/// change of sign is narrowed down (algorithm 748) to 1e-11, each turning point between two steps looked at.
/// All budgets are evaluated by the theory that the targets of the task come from: GHS, or the geometric
/// closed form. With a second unknown also the contour, by predictor and corrector along the curve, arc
/// length in logarithms; every point of it on the strictest budget to 1e-9. With a confidence the values are
/// those that so many mirrors are no worse than: mean light less so many standard deviations of it
/// (`RealisationSpread`, taken as normal), heights and angles with those of their samples; sensitivities are
/// then differences. Throws FieldError for a confidence without GHS, for a theory
/// without a closed form (`rays`) and for starts that are not above zero; ComputationError where the start
/// cannot be computed.
Specification solve_specification(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns,
                                  const std::vector<Budget>& budgets, const SolveOptions& options,
                                  const RunContext& context);

}  // namespace aberfit
