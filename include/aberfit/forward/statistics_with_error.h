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

/// Share of neighbouring cells whose phases may alias (LightPath::aliased_limit) on a grid that a finer one
/// follows where it matters: while a fit goes on, in a look of a verdict that a closer one may follow, and on
/// the grids that tell its error.
inline constexpr double kMostAliasedBeforeAFiner = 2e-2;

/// A mirror in its light, on no particular pupil points.
struct LitMirror {
  const Mirror& mirror;
  const Aperture& aperture;
  double wavelength = 0;                            ///< [m]; needed for kWaves
  Centre centre = Centre::kNominal;                 ///< kCentroid: kRays only
  std::shared_ptr<const MeanScatter> scatter = {};  ///< as LightPath has it
};

/// Where a model looks at the pupil anew.
struct FreshPupil {
  FocusModel model = FocusModel::kRays;
  std::int64_t rays = 0;          ///< kRays: wanted number, 8 to 4 million (2^22), clamped to that
  std::uint64_t seed = 1;         ///< kRays: of the scrambles
  double pitch = 0;               ///< kWaves: of the grid that judges [m]
  bool single_precision = false;  ///< kWaves: as DiffractionProblem has it
  /// kWaves: the first grid on which a statistic has no value is the last that is looked at, and nothing has
  /// a value or an error then: for who goes to a finer grid anyway.
  bool all_or_nothing = false;
};

/// Statistics of a surface and how well its pupil sample knows them.
struct FreshStatistics {
  Eigen::VectorXd value;
  Eigen::VectorXd standard_error;  ///< of waves, the bound
  bool errors_are_bounds =
      false;  ///< `standard_error` bounds the error (waves) instead of spreading about it
  /// That the errors are known by: kScrambles - 1 by rays, infinite by waves.
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
  Eigen::Index rays = 0, lost = 0;  ///< rays: of waves, cells of the finer grid
};
/// Standard error of the mean of each row.
Eigen::VectorXd standard_error_of_mean(const Eigen::MatrixXd& samples);
inline constexpr int kScrambles = 8;
/// Here the sampling error of ee90 is below 0.03 % even by the law of random points (PHYSICS 2: 0.51 % for
/// 15,000), and below that for Sobol points; more only takes memory.
inline constexpr std::int64_t kMostFreshRays = std::int64_t(1) << 22;
/// Pitch of the grids that waves are compared with, over that of the one that judges. No multiple, so that no
/// cell of one grid is a cell of the other.
inline constexpr double kCoarserGrid = 1.37;
/// The grid that rings are searched for on, which takes several times as many planes as to follow them; where
/// it is too coarse for the surface, the next one searches.
inline constexpr double kSearchGrid = 2.5;

/// Exact statistics of the surface with `coefficients` [m] of `terms`, and their stated error, on points that
/// no fit has seen.
///   kRays: on the union of kScrambles independently scrambled Sobol pupils of rays/kScrambles points each;
///     the error is the standard error of the mean of the scrambles' own statistics, s/sqrt(kScrambles)
///     (Owen, Monte Carlo Theory, Methods and Examples, 2013, 17), itself known to a quarter: intervals take
///     Student's t. It falls faster
///     than N^-1/2 (N^-0.7 to N^-1.1 seen), and does not see a bias that all scrambles share,
///     O(kScrambles/N).
///   kWaves: on a grid of `pitch`; the error is a bound, 1.5 times the largest difference from three grids
///     1.37 times coarser or a little less, that differ in pitch and in where their cells lie. It stands on
///     errors of second order in the pitch or better, which fall as pitch^2 to pitch^4 where the grid has
///     three cells a cycle of the highest term (wave_pitch), with signs that change as cells cross the edge.
///     It holds in 95 % of the cases and is 3 to 5 times the median error (tests/forward).
/// RMS height and the angles of scatter are the surface's own, exact for the order of its terms
/// (term_moments.h), with an error of zero, the mean angle of kMeanAngleError; by rays, where a polygon has a
/// margin, they are estimated like the rest. NaN, and a warning when `warnings` is given, where a statistic
/// does not exist. The same bits for any number of threads. Throws as make_forward_model does.
FreshStatistics statistics_with_error(const LitMirror& lit, const FreshPupil& pupil, const TermSet& terms,
                                      const Eigen::VectorXd& coefficients,
                                      const std::vector<Statistic>& statistics, int threads,
                                      Warnings* warnings);

}  // namespace aberfit
