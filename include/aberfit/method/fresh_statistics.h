#pragma once
#include "aberfit/forward/forward_model.h"
#include "aberfit/method/scene.h"
#include "aberfit/method/outcome.h"

namespace aberfit {

/// Statistics of a term surface on fresh rays: the mean surface's exact statistics on the union of kScrambles
/// independently scrambled Sobol pupils, and their standard error from the spread between the scrambles.
struct FreshStatistics {
  Eigen::VectorXd value, standard_error;
  Eigen::Index rays = 0, lost = 0;
};
inline constexpr int kScrambles = 8;
/// rays: wanted number, 8 to 4 million.
FreshStatistics evaluate_fresh(const Task& task, const TermSet& terms, const Eigen::VectorXd& coefficients,
                               const std::vector<Statistic>& statistics, std::int64_t rays, int threads,
                               Warnings* warnings);

/// The same through the model that judges. Rays: as above. Waves: on a grid 1.37 times finer than `pitch`
/// [m]; the standard error is the difference from the grid of `pitch`, so it holds what a fit has made of its
/// own grid. `rays` there counts cells.
FreshStatistics evaluate_fresh(const Task& task, FocusModel model, double pitch, const TermSet& terms,
                               const Eigen::VectorXd& coefficients, const std::vector<Statistic>& statistics,
                               std::int64_t rays, int threads, Warnings* warnings);

/// ee90 at z = f of `draws` seeded draws of the prior: their standard deviation over their mean. Draws
/// without an ee90 are left out; NaN with fewer than two.
double measured_spread(const LightPath& path, const CoefficientPrior& prior, std::uint64_t seed, int draws,
                       int threads);

/// Slope RMS per aperture zone (edges 0, .25, .5, .75, 1) over the overall one, of `coefficients` and of
/// draws from `prior`.
std::vector<ZoneSlope> zone_slopes(const Task& task, const TermSet& terms, const CoefficientPrior& prior,
                                   const Eigen::VectorXd& coefficients, int threads);

}  // namespace aberfit
