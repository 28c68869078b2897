#pragma once
#include <optional>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/method/run_context.h"
#include "aberfit/method/task.h"
#include "aberfit/specify/budget.h"

// Roughness that budgets allow a mirror with unknown PSD: limits per octave, and lines of a drawing.
namespace aberfit {

/// Options of find_ceilings.
struct CeilingsSpec {
  std::optional<double> f_min, f_max;  ///< [cycles/m]; absent: 1 and 1000 cycles across the aperture
  std::vector<double> exponents = {1, 1.5, 2, 2.5, 3};  ///< exponents B of the lines, ascending, > 0
};

/// Largest roughness in one octave if there is no other. Two octaves cannot both be at their ceilings.
struct OctaveCeiling {
  /// centre frequency [cycles/m]; the octave is from frequency/sqrt(2) to frequency sqrt(2)
  double frequency = 0;
  double rms = 0;          ///< RMS height [m]; infinite: no height found that violates a budget
  double profile_psd = 0;  ///< rms^2 over the width of the octave: a level of the one-sided profile PSD [m^3]
  std::size_t binding = 0;  ///< index of the budget that limits it; undefined if rms is infinite
  std::string reason;       ///< a sentence if no ceiling was found
};

/// Largest profile PSD A/f^B over the band (ISO 10110-8), for a surface without other roughness.
struct LineCeiling {
  double exponent = 0;      ///< B
  double level = 0;         ///< A/f^B at 1 cycle/mm, one-sided [m^3]; infinite as above
  double rms = 0;           ///< RMS height of the surface over the band [m]
  std::size_t binding = 0;  ///< as above
  double headroom = 0;  ///< least ratio of an octave's ceiling to the RMS height of the line in that octave
  double closest = 0;   ///< frequency of that octave [cycles/m]
  std::string reason;   ///< as above
};

struct Ceilings {
  std::string title;
  double f_min = 0, f_max = 0;  ///< [cycles/m]
  double across = 0;            ///< diameter of the circumscribed circle of the aperture [m]
  double focal_length = 0;      ///< [m]
  Theory theory = Theory::kGhs;
  std::vector<Budget> budgets;
  std::vector<double> perfect;  ///< budgeted quantities without roughness [m] or [rad]
  std::vector<OctaveCeiling>
      octaves;  ///< ascending, half an octave apart; the first and the last reach the ends of the band
  std::vector<LineCeiling> lines;  ///< ascending in exponent
  /// why there are no ceilings: a budget that the perfect mirror violates; otherwise empty
  std::string reason;
  int evaluations = 0;
  double seconds = 0;
  Warnings warnings;
};

/// Solves for each octave and each line by solve_specification. The ceiling is the smallest height at which a
/// budget is violated, to 1e-11 in its logarithm. The roughness of the task is not used. Throws FieldError
/// for a band of less than an octave and for whatever solve_specification refuses.
Ceilings find_ceilings(const Task& task, const CeilingsSpec& asked, const std::vector<Budget>& budgets,
                       const RunContext& context);

}  // namespace aberfit
