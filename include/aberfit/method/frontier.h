#pragma once
#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/method/tost.h"

namespace aberfit {

/// One of the sets of terms of a run that tried several, or searched for the fewest.
struct FrontierPoint {
  std::string family = "zernike";  ///< or "fourier"
  int order = 0;                   ///< Zernike: n_max; Fourier: number of plane waves
  Eigen::Index terms = 0, rays = 0;
  double fitted_mismatch = 0;  ///< largest |S - T| / tolerance over the fitted statistics
  double held_out_mismatch =
      NAN;  ///< largest judged difference of the held-out statistics on fresh rays; NaN: not judged
  double seconds = 0;
  std::optional<Verdict> verdict;  ///< on fresh rays; absent where it was not judged
  bool passes = false;             ///< `equivalent`
  bool chosen = false;
};

/// The sets that were tried, by ascending number of terms, and their results.
struct Frontier {
  std::vector<FrontierPoint> points;
  bool fewest = false;  ///< the run searched for the fewest; else the terms by the law, or more
  double seconds = 0;   ///< sum over all sets
  double margin = 0;    ///< of the verdicts, relative
  std::string message;  ///< one sentence: which terms were taken and why
};

/// The number of rays of the fit, and its reason. It describes the fit itself. A verdict left open by the
/// sampling error may since have used more fresh rays.
struct RayChoice {
  bool automatic = false;
  double gap = NAN;             ///< largest |S_fit - S_fresh| / |T| over the fitted statistics
  double sampling_error = NAN;  ///< largest standard error of a fitted statistic on the fresh rays, over |T|
  double allowed = 0;           ///< upper limit for both
  std::string reason;           ///< one sentence
};

/// The part of the specification's band that terms and rays can represent, and what lies above it. Shares are
/// fractions of the specification's variances. ee90 follows the slope: leaving out a fraction u of the slope
/// variance changes it by sqrt(1 - u) - 1 (PHYSICS 5), unless a fit moves that slope into the modelled part.
struct BandUse {
  double modelled_f_min = 0, modelled_f_max = 0;  ///< [cycles/m]
  std::string limited_by;  ///< cause of modelled_f_max: "specification", "zernike", "fourier" or "rays"
  double left_out_height_share = 0, left_out_slope_share = 0;
  double ee90_change = 0;
};

/// The split of a roughness between terms and scatter.
struct BandShares {
  double cut = 0;                              ///< [cycles/m]; 0: all of it scatters
  bool automatic = false;                      ///< chosen by the spread of single mirrors
  double low_rms = 0, rest_rms = 0;            ///< RMS heights below and above the cut [m]
  double low_slope = 0, rest_slope = 0;        ///< RMS slopes per axis
  double rest_scatter = 0;                     ///< RMS scatter angle of the rest [rad]
  double tis = 0;                              ///< fraction of the energy that the rest scatters
  double height_spread = 0, slope_spread = 0;  ///< relative standard deviations of RMS height, slope
  double spread = 0;      ///< largest standard deviation of a judged statistic between mirrors, in tolerances
  std::string spread_of;  ///< the statistic with that spread
  /// RMS heights [m] of a measured part: the residual of the map, and the residual that the terms would leave
  /// of the specification. The rest of the split represents both, so neither is added to it.
  double map_residual = NAN, specified_residual = NAN;
  std::string reason;  ///< one sentence
};

}  // namespace aberfit
