#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/method/run_context.h"
#include "aberfit/method/task.h"
#include "aberfit/specify/budget.h"

// Finds the roughness that meets a budget. Parameters of the PSD are unknowns; statistics of the theory
// (PHYSICS 5, 6) are functions of them. Neither a fit nor random realisations are needed.
namespace aberfit {

/// An unknown parameter of a study.
struct SolveUnknown {
  std::string pointer;  ///< JSON pointer in the study, "/roughness/psd/rms"
  double start = 0;     ///< value in the study, > 0 [its SI unit]
  Dimension dimension = Dimension::kNumber;
  std::string part = {};  ///< name of the part of a sum that it belongs to, for display; empty: no sum
};

/// Returns the task for given unknowns. Throws InputError if they are not allowed.
using TaskAt = std::function<Task(const std::vector<double>& values)>;

/// One budget at one set of unknowns.
struct BudgetState {
  double value = 0;   ///< budgeted quantity [m] or [rad]; infinite if the radius exceeds f
  double margin = 0;  ///< (limit - value)/limit for <=, (value - limit)/limit for >=; negative: violated
  /// d ln(value)/d ln(unknown) for each unknown, exact (theory/psd_jacobian.h). If the study computes the
  /// parameters of the PSD from the unknown, central differences of 1e-3 are used, error about 1e-6.
  std::vector<double> sensitivity;
};
/// All budgets at one set of unknowns.
struct SolvePoint {
  std::vector<double> at;  ///< value of each unknown [its SI unit]
  std::vector<BudgetState> budgets;
  std::size_t binding = 0;          ///< index of the budget with the least margin
  std::array<double, 2> bracket{};  ///< for a solution: the neighbouring steps of the search around it
  bool holds_below = true;          ///< for a solution: true if budgets hold below it, false if above
};
/// The end of the search for one unknown.
struct RangeEnd {
  double value = 0;  ///< last value that could be computed
  std::string why;
};

enum class SolveStatus {
  kNotRun,
  kSolved,
  kNoSolution,  ///< nowhere in the range do all budgets hold
  kUnbounded,   ///< all budgets hold in the whole range
};
std::string to_string(SolveStatus status);

struct SolveOptions {
  double step = 1.5;  ///< factor between neighbouring steps of the search; closer pairs of roots count as one
  double decades = 4;          ///< range of the search on either side of the start
  double contour_decades = 1;  ///< range of a contour on either side in each unknown
  /// Fraction of the mirrors for which a budget must hold, in (0.5, 1); 0: it must hold for their mean.
  double confidence = 0;
};

/// Contribution of one element of a path to the budgets (contributors.h).
struct BudgetUse {
  std::string name;
  std::vector<double> alone;    ///< budgeted quantities with this contributor only [m], [rad] or [1]
  std::vector<double> without;  ///< the same with all other contributors
};

/// Curve in two unknowns on which the strictest budget is exactly met.
struct Contour {
  std::vector<SolvePoint> points;  ///< in order along the curve
  bool is_closed = false;
  std::array<std::string, 2> ends;  ///< why the curve ends there
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
  std::vector<SolvePoint> solutions;       ///< in the first unknown, nearest to the start first
  SolvePoint nearest;                      ///< least violated (kNoSolution), or least margin (kUnbounded)
  std::vector<std::vector<double>> alone;  ///< solutions for each budget alone, nearest first
  std::vector<BudgetState> perfect;        ///< mirror without roughness
  std::array<RangeEnd, 2> range;           ///< range of the first unknown
  std::string reason;                      ///< why there is no solution, or no bound
  Contour contour;                         ///< for two unknowns
  std::vector<BudgetUse> uses;             ///< at the first solution; empty for a mirror alone
  int evaluations = 0;
  double seconds = 0;
  Warnings warnings;
};

/// Solves for the first unknown with the others at their starts. The search takes geometric steps both ways
/// until a value is refused, the theory ends, nothing changes any more, or options.decades are reached. Each
/// change of sign is refined (algorithm 748) to 1e-11, each turning point between two steps is examined.
/// All budgets are evaluated by the theory of the task's targets: GHS, or the geometric closed form. With a
/// second unknown the contour follows by predictor and corrector, with arc length in logarithms; each of its
/// points is on the strictest budget to 1e-9.
/// With a confidence, this fraction of the mirrors are not worse than each value. The encircled energy is
/// reduced by that number of standard deviations (`RealisationSpread`, assumed normal); heights and angles
/// use those of their samples. Sensitivities are then differences.
/// Throws FieldError for a confidence without GHS, for a theory without a closed form (`rays`) and for starts
/// that are not positive; ComputationError if the start cannot be computed.
Specification solve_specification(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns,
                                  const std::vector<Budget>& budgets, const SolveOptions& options,
                                  const RunContext& context);

}  // namespace aberfit
