#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"
#include "aberfit/terms/term_set.h"
#include "aberfit/theory/vocabulary.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {

/// Fraction of neighbouring grid cells whose phases may alias (LightPath::aliased_limit) if a finer grid can
/// still follow. This holds during a fit, on the first judging grid, and on the grids that give its error.
inline constexpr double kMostAliasedBeforeAFiner = 2e-2;

/// A mirror and its wavelength, without particular pupil points.
struct LitMirror {
  const Mirror& mirror;
  const Aperture& aperture;
  double wavelength = 0;                            ///< [m]; needed for kWaves
  Centre centre = Centre::kNominal;                 ///< kCentroid: kRays only
  std::shared_ptr<const MeanScatter> scatter = {};  ///< see LightPath
};

/// A fresh sample of the pupil.
struct FreshPupil {
  FocusModel model = FocusModel::kRays;
  std::int64_t rays = 0;          ///< kRays: requested number, clamped to 8 to 4 million (2^22)
  std::uint64_t seed = 1;         ///< kRays: of the scrambles
  double pitch = 0;               ///< kWaves: pitch of the judging grid [m]
  bool single_precision = false;  ///< kWaves: see DiffractionProblem
  /// kWaves: stops at the first grid on which a statistic has no value, and then gives no values or errors.
  /// For callers that go to a finer grid anyway.
  bool all_or_nothing = false;
};

/// Statistics of a surface and the sampling error of its pupil points.
struct FreshStatistics {
  Eigen::VectorXd value;
  Eigen::VectorXd standard_error;  ///< for waves, the bound
  bool errors_are_bounds =
      false;  ///< `standard_error` is a bound of the error (waves), not a standard deviation
  /// Degrees of freedom of the errors: kScrambles - 1 by rays, infinite by waves.
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
  Eigen::Index rays = 0, lost = 0;  ///< rays: for waves, cells of the finer grid
};
/// Standard error of the mean of each row.
Eigen::VectorXd standard_error_of_mean(const Eigen::MatrixXd& samples);
inline constexpr int kScrambles = 8;
/// With this number the sampling error of ee90 is below 0.03 % even by the law of random points (PHYSICS 2:
/// 0.51 % for 15,000), and smaller for Sobol points. More rays only take memory.
inline constexpr std::int64_t kMostFreshRays = std::int64_t(1) << 22;
/// Pitch of the comparison grids over that of the judging grid; no integer, so that no cells coincide.
inline constexpr double kCoarserGrid = 1.37;
/// Pitch, over that of the judging grid, of the grid on which rings are searched; a search needs several
/// times as many planes as following them. Where it is too coarse for the surface, the next grid searches.
inline constexpr double kSearchGrid = 2.5;

/// Exact statistics of the surface with `coefficients` [m] of `terms`, and their stated error, on points that
/// no fit has used.
/// kRays: the union of kScrambles independently scrambled Sobol pupils of rays/kScrambles points each. The
/// error is the standard error of the mean of the scrambles' own statistics, s/sqrt(kScrambles) (Owen, Monte
/// Carlo Theory, Methods and Examples, 2013, 17). It is known to a quarter, so intervals use Student's t. It
/// falls faster than N^-1/2 (N^-0.7 to N^-1.1 seen) and does not include the bias that all scrambles share,
/// O(kScrambles/N).
/// kWaves: a grid of `pitch`. The error is a bound: 1.5 times the largest difference from three grids, 1.37
/// times coarser or a little less, which differ in pitch and in the position of their cells. It assumes
/// errors of second order in the pitch or better, pitch^2 to pitch^4 for three grid cells per cycle of the
/// highest term (wave_pitch). It holds in 95 % of the cases and is 3 to 5 times the median error
/// (tests/forward).
/// RMS height and scatter angles are the surface's own, exact for the order of its terms (term_moments.h),
/// with zero error; the mean angle has kMeanAngleError. By rays, for a polygon with a margin, they are
/// estimated like the rest.
/// NaN, and a warning unless `warnings` is null, where a statistic does not exist. The result has the same
/// bits for any number of threads. Throws as make_forward_model does.
FreshStatistics statistics_with_error(const LitMirror& lit, const FreshPupil& pupil, const TermSet& terms,
                                      const Eigen::VectorXd& coefficients,
                                      const std::vector<Statistic>& statistics, int threads,
                                      Warnings* warnings);

}  // namespace aberfit
