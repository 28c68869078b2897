// Tests Edge::judge itself: each breach fails, and its permitted neighbour passes.
#include "edge.h"

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

namespace aberfit::test {
namespace {

// Error 1e-6 p^2 against a promise of 1e-4, reported from p = `told_from` on.
Edge sweep_of(double last, double told_from, double constant = 1e-6) {
  Edge edge("edge_of_the_tests_own", "parameter [1]", "error [1]");
  for (const double p : geometric_steps(1, last, 13)) edge.add({p, 1e-6 * p * p, 1e-4, p >= told_from});
  edge.follows({"1e-6 p^2", [constant](double p) { return constant * p * p; }, 1, last, 1.01});
  return edge;
}

TEST(Edge, PassesWhereAllBeyondThePromiseIsTold) { sweep_of(100, 9).judge(); }
TEST(Edge, FailsWhereAnErrorIsReturnedWithoutAWord) {
  EXPECT_NONFATAL_FAILURE(sweep_of(12, 13).judge(), "without a word; promised: 0.0001");
}
TEST(Edge, FailsWhereTheEdgeIsNotReached) {
  EXPECT_NONFATAL_FAILURE(sweep_of(9, 100).judge(), "never came to the edge");
}
TEST(Edge, FailsWhereAWordIsAlwaysSaid) {
  EXPECT_NONFATAL_FAILURE(sweep_of(100, 0).judge(), "the word says nothing");
}
TEST(Edge, FailsWhereNothingIsReturnedAndNothingSaid) {
  Edge edge = sweep_of(100, 9);
  edge.add({200, std::numeric_limits<double>::quiet_NaN(), 1e-4, false});
  EXPECT_NONFATAL_FAILURE(edge.judge(), "the error is nan without a word");
}
TEST(Edge, FailsWhereTheLawDoesNotHold) {
  ::testing::TestPartResultArray found;
  {
    const ::testing::ScopedFakeTestPartResultReporter reporter(
        ::testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &found);
    sweep_of(100, 9, 1.02e-6).judge();
  }
  EXPECT_EQ(found.size(), 13);
}

}  // namespace
}  // namespace aberfit::test
