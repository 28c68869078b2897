#pragma once
#include <string>
#include <utility>
#include <vector>

#include "aberfit/chart/fit_work.h"

namespace aberfit {

/// What a chart was measured at, for its reader.
struct FitSize {
  double rays = 0, terms = 0;
  double fitted = 0;  ///< targets and guides
  double judged = 0;  ///< targets and held-out statistics
  double zone_points = 0;
  double threads = 1;
};

/// How fast a machine is: times of the stages of one fit as measured, and as fit_work expects them [s].
struct FitRates {
  FitSize size;
  FitWork measured;  ///< iteration: its share of rejected steps and of the start included
  FitWork expected;
  double iterations = 0;
  bool iterations_known = false;     ///< the fit was run to its end, and on rays
  double forward = 0, jacobian = 0;  ///< smooth values; the same with the full Jacobian
  double exact = 0;                  ///< one exact evaluation of the targets on the fitted rays
  double waves = 0;    ///< time of wave optics over what fit_work expects; 0: as the iteration has it
  WavePace pace = {};  ///< of the rest of a fit by waves beside it
  std::string source;  ///< where they come from, a clause
};

/// Rates of the machine that the constants come from; for studies without a chart.
FitRates built_in_rates();
/// The same with the speed of this machine, measured in 0.3 s: of terms at points, of focal planes with
/// gradients and of products, on as many threads at once as a fit will have.
FitRates machine_rates(int threads);

/// What `fit` will take, in order of its stages; first start only, pictures left out.
struct FitPrediction {
  std::vector<std::pair<std::string, double>> stages;  ///< [s]
  double seconds = 0;                                  ///< their sum
  double iterations = 0;                               ///< of each full fit
  bool iterations_known = false;                       ///< of this task, by its chart; else a typical number
  bool search = false;                                 ///< for the fewest terms
  bool more_rays = false;                              ///< a second fit on twice the rays is counted in
};

/// terms: of the task, where it names them; for `"terms": "auto"` sets between expected_orders are put in
/// for them: as many as a search typically fits.
FitPrediction predict_fit(const Task& task, const Groundwork& ground, const TermSet& terms,
                          const TargetSets& targets, const FitRates& rates, int threads);

/// Predicted time [s] of the least squares of a map of `points` with `terms`.
double predict_map_fit(double points, double terms, int threads);

}  // namespace aberfit
