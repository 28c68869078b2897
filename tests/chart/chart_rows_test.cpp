#include <gtest/gtest.h>

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
  // Two rows are equally fast and differ in accuracy; two are equally accurate and differ in time.
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

}  // namespace
}  // namespace aberfit
