#pragma once
#include <vector>

#include "aberfit/method/groundwork.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// Times of the stages of one fit [s]: counts of operations times the constants of fit_work.cpp, that is on
/// `threads` AVX-512 cores.
struct FitWork {
  double targets = 0, prior = 0;
  double iteration = 0;                    ///< one: values, and one pull-back through L^T per statistic
  double ends = 0;                         ///< the start, its statistics and those of the result
  double fresh = 0;                        ///< the verdict on fresh rays, or on a finer grid
  double realisations = 0, judgement = 0;  ///< 0 where `fit` leaves them out
  double zones = 0;
  double draws = 0;    ///< that judge a roughness without terms (all_scatter.h)
  double scatter = 0;  ///< the scatter function of the rest of a split, and its fits
  double led = 0;  ///< fits by rays that lead a fit by waves to its start; 0 where it starts from its draw
};

/// What of the work of waves another machine does slower or faster than the rest of it: times over those of
/// the constants, relative to a plane of a small grid.
struct WavePace {
  double large = 1;     ///< planes of grids beyond the caches, 450 cells across and more; in between by log M
  double products = 1;  ///< L^T of heights, dense algebra
  double terms = 1;     ///< L, L^T but of heights, and fits by rays
};

/// Of these terms on `rays`, by the scene's physics:
///   rays        every statistic looks at every ray and lists a few of them for its gradient;
///   waves       every plane and every gradient takes M_x M_y log2 of the padded transform, M by wave_pitch.
///               Planes: one per distinct dz, and those of the search of each RingFwhm.
/// Each gradient costs one L^T (operator_cost.h). Nothing is timed: a function of its arguments and the
/// instruction set.
FitWork fit_work(const Task& task, const Groundwork& ground, const TermSet& terms, const PupilOptions& rays,
                 const TargetSets& targets, int threads, const WavePace& pace = {});

/// Cells across of the grids that a machine's pace is measured on. Beyond the larger it stays: 0.53 of the
/// constants at 200 cells, 0.67 at 288, 0.89 at 450, 0.84 at 600, 0.87 at 1400.
inline constexpr int kSmallGrid = 96, kLargeGrid = 450;
/// One thread's time [s] for one plane of a pupil of so many cells across, with the energy inside so many
/// rings and its gradients over the heights, by the same constants.
double wave_seconds(int across, int statistics);
/// The same for L^T of so many height weights with so many Zernikes at so many points.
double product_seconds(Eigen::Index points, Eigen::Index terms, int weights);

/// Points of the pupil that slopes of zones are reckoned with; 0 for spherical terms, which it leaves out.
double zone_points(const TermSet& terms);

}  // namespace aberfit
