#pragma once
#include <optional>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/method/run_context.h"
#include "aberfit/method/task.h"
#include "aberfit/specify/budget.h"

// How rough a mirror may be where nothing is known of its PSD yet: what budgets allow frequency by frequency,
// and the lines of a drawing that meet them.
namespace aberfit {

/// What is asked.
struct CeilingsSpec {
  std::optional<double> f_min, f_max;  ///< [cycles/m]; absent: 1 and 1000 cycles across the aperture
  std::vector<double> exponents = {1, 1.5, 2, 2.5, 3};  ///< B of the lines, ascending, > 0
};

/// The most roughness about one frequency, if there were none anywhere else. Ceilings of two octaves cannot
/// be reached together.
struct OctaveCeiling {
  double frequency = 0;     ///< [cycles/m]; of the octave from frequency/sqrt(2) to frequency sqrt(2)
  double rms = 0;           ///< RMS height [m]; infinity: none was found to violate a budget
  double profile_psd = 0;   ///< rms^2 over the octave's width: a level of one-sided profile PSD [m^3]
  std::size_t binding = 0;  ///< the budget that ends it; of no meaning where rms is infinite
  std::string reason;       ///< why none was found, a sentence
};

/// The largest profile PSD A/f^B over the band that may be used up entirely: the form of ISO 10110-8, for a
/// surface that has nothing beside it.
struct LineCeiling {
  double exponent = 0;      ///< B
  double level = 0;         ///< A/f^B at 1 cycle/mm, one-sided [m^3]; infinity as above
  double rms = 0;           ///< RMS height of the surface over the band [m]
  std::size_t binding = 0;  ///< as above
  double headroom = 0;      ///< least ratio of an octave's ceiling to what the line has there, RMS heights
  double closest = 0;       ///< [cycles/m], where that is
  std::string reason;       ///< as above
};

struct Ceilings {
  std::string title;
  double f_min = 0, f_max = 0;  ///< [cycles/m]
  double across = 0;            ///< diameter of the aperture's circumscribed circle [m]
  double focal_length = 0;      ///< [m]
  Theory theory = Theory::kGhs;
  std::vector<Budget> budgets;
  std::vector<double> perfect;  ///< what the budgets limit, without roughness [m] or [rad]
  std::vector<OctaveCeiling>
      octaves;                     ///< ascending, half an octave apart; the first and the last end the band
  std::vector<LineCeiling> lines;  ///< ascending in exponent
  std::string reason;  ///< why there are none: a budget that the perfect mirror violates; else empty
  int evaluations = 0;
  double seconds = 0;
  Warnings warnings;
};

/// Each octave and each line by solve_specification, from the least height on: the first at which a budget is
/// violated, to 1e-11 in its logarithm. The task's own roughness is not looked at. Throws FieldError for a
/// band of less than an octave and for what solve_specification refuses.
Ceilings find_ceilings(const Task& task, const CeilingsSpec& asked, const std::vector<Budget>& budgets,
                       const RunContext& context);

}  // namespace aberfit
