#pragma once
#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/method/tost.h"

namespace aberfit {

/// One of the sets of terms that a run tried, where it tried more than one or was asked for the fewest.
struct FrontierPoint {
  std::string family = "zernike";  ///< or "fourier"
  int order = 0;                   ///< Zernike: n_max; Fourier: number of plane waves
  Eigen::Index terms = 0, rays = 0;
  double fitted_mismatch = 0;  ///< largest |S - T| / tolerance over the fitted statistics
  double held_out_mismatch =
      NAN;  ///< largest judged difference of the held-out ones on fresh rays; NaN: not judged
  double seconds = 0;
  std::optional<Verdict> verdict;  ///< on fresh rays; nothing where it was not judged
  bool passes = false;             ///< `equivalent`
  bool chosen = false;
};

/// The sets that were tried, by ascending number of terms, and what came of it.
struct Frontier {
  std::vector<FrontierPoint> points;
  bool fewest = false;  ///< the fewest were asked for; else the law's set, and what it grew to
  double seconds = 0;   ///< of all of them
  double margin = 0;    ///< of the verdicts, relative
  std::string message;  ///< one sentence: which terms were taken and why
};

/// How many rays the fit used, and why.
/// As it was made; a verdict that rays' own error left open may have been judged on more fresh rays since.
struct RayChoice {
  bool automatic = false;
  double gap = NAN;             ///< largest |S_fit - S_fresh| / |T| over the fitted statistics
  double sampling_error = NAN;  ///< largest standard error of a fitted statistic on the fresh rays, over |T|
  double allowed = 0;           ///< what both have to stay below
  std::string reason;           ///< one sentence
};

/// The part of the specification's band that terms and rays can represent, and what lies above it. Shares are
/// of the specification's variances. ee90 follows the slope: leaving a share u of the slope variance out
/// changes it by sqrt(1 - u) - 1 (PHYSICS 5), unless a fit puts the slope into the modelled part.
struct BandUse {
  double modelled_f_min = 0, modelled_f_max = 0;  ///< [cycles/m]
  std::string limited_by;  ///< "specification", "zernike", "fourier" or "rays": what sets modelled_f_max
  double left_out_height_share = 0, left_out_slope_share = 0;
  double ee90_change = 0;
};

/// How a roughness is shared out between terms and scatter.
struct BandShares {
  double cut = 0;                              ///< [cycles/m]; 0: all of it scatters
  bool automatic = false;                      ///< chosen by its spread
  double low_rms = 0, rest_rms = 0;            ///< heights [m]
  double low_slope = 0, rest_slope = 0;        ///< RMS slopes per axis
  double rest_scatter = 0;                     ///< RMS scatter angle [rad]
  double tis = 0;                              ///< share of the light that the rest scatters
  double height_spread = 0, slope_spread = 0;  ///< of sample RMS height and slope, over that of the whole
  double spread = 0;      ///< largest standard deviation of judged light between such mirrors, in tolerances
  std::string spread_of;  ///< statistic
  /// Of a measured part: what its terms leave of the map, and what they would leave of the specification on
  /// it, RMS heights [m]. The rest stands for both: neither is added to it.
  double map_residual = NAN, specified_residual = NAN;
  std::string reason;  ///< one sentence
};

}  // namespace aberfit
