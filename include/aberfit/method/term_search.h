#pragma once
#include <functional>

#include "aberfit/method/frontier.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/task.h"

namespace aberfit {

/// Fits by waves on so many cells take ten seconds a set, and as much for each verdict.
inline constexpr Eigen::Index kManyCells = 20000;
/// On so many a set takes ten seconds and more, and one that fails half to all of what the one that passes
/// does; a verdict takes as long as the fit.
inline constexpr Eigen::Index kVeryManyCells = 100000;

/// What a fit of these terms came to; the search fills in `order` and `family`.
using TryTerms = std::function<FrontierPoint(const TermsSpec& asked)>;

/// How the search looks at a set.
struct TermTrials {
  /// A short fit on few rays, warm-started from the one before: tells how far from the tolerances a set
  /// stays. Empty where such fits say nothing: then every look is a full fit, and the search takes as many
  /// orders at once as the last one was away from its tolerances, or as the pace of the last two says.
  TryTerms screen;
  /// The fit of these terms, judged on fresh rays. What it says is the answer.
  TryTerms confirm;
  /// Cells of the grid that `confirm` begins on. Empty: few, or rays.
  std::function<Eigen::Index(const TermsSpec& asked)> cells;
};

/// Orders that the search climbs: every one up to 14, then steps of at most 9 % (18 % in terms), at least 1.
int next_order(int order);
/// How many orders a search without short fits goes up at least from one whose set stays this many tolerances
/// away.
int stride(int order, double mismatch);
/// A set whose short fit on few rays stays this many tolerances away is given up; see term_search_sweep_test.
inline constexpr double kPromising = 10;
/// Zernike order that the search climbs to at most; a roughness that 99 % of the height need more for is
/// given Fourier modes.
inline constexpr int kLargestSearchedOrder = 100;

/// The orders the search of a task expects to end at: from where the Zernikes carry 15 % of the slope
/// variance to two steps beyond where they carry 99 % of the height variance.
struct OrderRange {
  int low = 2, high = 2;
  bool wide = false;  ///< above kLargestSearchedOrder: Fourier modes
  int first = 2;      ///< where the sets begin: 1 where tilt is more than kTiltMatters of the height variance
};
/// Share of the height variance about the mean from which tilt is among the terms. Without it sets have to
/// stand for the motion of the image by other shapes, and cannot: with waves of half a cycle across (tilt 42
/// %) sets to n = 17 stay 4 tolerances away and those with tilt meet them to 0.7.
inline constexpr double kTiltMatters = 0.05;
OrderRange expected_orders(const Groundwork& ground);

/// The terms that an order of a search stands for.
TermsSpec zernikes_up_to(int order, CovarianceKind covariance, int first = 2);
TermsSpec plane_waves(int count);

/// The fewest terms that pass, by climbing through the orders: screens each, confirms the promising ones, and
/// goes down from the first that passes until two in a row do not. Without screening it strides up and
/// halves what it stepped over, then goes down in the same way. On kManyCells it ends within 9 % of the order
/// that it takes, which is above neighbours from 23 on; on 100,000 within 20 %, on 150,000 within half, and
/// begins a quarter of the way through the expected orders and takes those below them to fail. Plane waves
/// are found to a factor 1.2, on kManyCells 1.5, on 100,000 2, there from 64 on; 2, too, where the first that
/// passes takes kMostAutomaticRays. Where none passes: the judged set with the smallest held-out mismatch,
/// else the one nearest to its tolerances, not fitted in full if screened. `chosen` is marked in the result,
/// which is sorted by terms. range: expected_orders; the climb ends a third beyond its high end. margin: of
/// the verdicts, told in the result.
Frontier search_terms(CovarianceKind covariance, double margin, const OrderRange& range,
                      const TermTrials& trials);
/// What came out, for people: a sentence without full stop.
std::string search_message(const Frontier& frontier, const OrderRange& range);

/// Where the modelled part of the band ends, and what the rest would be worth. rays: of the fit.
BandUse band_use(const Task& task, const Groundwork& ground, const TermSet& terms, Eigen::Index rays);

}  // namespace aberfit
