// Which rows of a chart are flagged, and the law of central differences.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "chart/hand_made_rows.h"

namespace aberfit {
namespace {

using test::family;
using test::kNone;
using test::row;

std::string frontier(const ChartFamily& f) {
  std::string names;
  for (const ChartRow& r : f.rows)
    if (r.on_frontier) names += r.method;
  return names;
}

std::string cheapest(const ChartFamily& f) {
  std::string names;
  for (const ChartRow& r : f.rows)
    if (r.is_cheapest_within_tolerance) names += r.method;
  return names;
}

TEST(ChartFrontier, HoldsWhatNothingBeats) {
  // b is slower and worse than a; d is slower than c at the same error; e is the most accurate.
  const ChartFamily f = family(
      {row("a", 1, 0.1), row("b", 2, 0.2), row("c", 3, 0.01), row("d", 4, 0.01), row("e", 9, 0)}, 0.05);
  EXPECT_EQ(frontier(f), "ace");
  EXPECT_EQ(cheapest(f), "c");
}

TEST(ChartFrontier, KeepsBothOfATieAndNeitherOfTwoThatAThirdBeats) {
  EXPECT_EQ(frontier(family({row("a", 1, 0.1), row("b", 1, 0.1)}, 1)), "ab");
  EXPECT_EQ(cheapest(family({row("a", 1, 0.1), row("b", 1, 0.1)}, 1)), "a");
  // Equally fast, one more accurate; equally accurate, one faster.
  EXPECT_EQ(frontier(family({row("a", 1, 0.2), row("b", 1, 0.1), row("c", 2, 0.1)}, 1)), "b");
  EXPECT_EQ(cheapest(family({row("a", 1, 0.2), row("b", 1, 0.1), row("c", 2, 0.1)}, 1)), "b");
  EXPECT_EQ(frontier(family({row("a", 2, 0.2), row("b", 2, 0.2), row("c", 1, 0.1)}, 1)), "c");
}

TEST(ChartFrontier, LeavesOutWhatHasNoErrorOrNoTime) {
  const ChartFamily f = family({row("a", 1, kNone), row("b", kNone, 0), row("c", 5, 0.5)}, 0.6);
  EXPECT_EQ(frontier(f), "c");
  EXPECT_EQ(cheapest(f), "c");
  EXPECT_EQ(frontier(family({}, 1)), "");
}

TEST(ChartFrontier, ClaimsNoToleranceThatIsMissedOrThatTheReferenceCannotTell) {
  EXPECT_EQ(cheapest(family({row("a", 1, 0.2), row("b", 2, 0.1)}, 0.05)), "");
  ChartRow vague = row("a", 1, 0.01);
  vague.error_of_reference = 0.1;
  EXPECT_EQ(cheapest(family({vague, row("b", 2, 0.01)}, 0.05)), "b");
  EXPECT_EQ(frontier(family({vague, row("b", 2, 0.01)}, 0.05)), "a");
}

TEST(StepLaw, HasItsBestStepWhereTruncationAndRoundingBalance) {
  // PHYSICS 8: uniform PSD to 1000 /m, s = 6.3e-6: best step (2.6e-15 / f_max^2)^(1/3).
  const double f_max = 1000, u = 2 * 3.14159265358979 * f_max;
  const StepLaw law{0.0932 * u * u, 1.2e-19 / 6.3e-6};
  const double best = std::cbrt(2.6e-15 / (f_max * f_max));
  EXPECT_NEAR(law.best_step(), best, 0.01 * best);  // two printed digits
  for (const double away : {0.8, 1.25}) EXPECT_GT(law(away * law.best_step()), law(law.best_step()));
}

}  // namespace
}  // namespace aberfit
