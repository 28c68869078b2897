#include "aberfit/core/root.h"

#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/core/constants.h"

namespace aberfit {
namespace {

const auto cosine = [](double x) { return std::cos(x); };

TEST(RootBetween, MeetsTheClosedFormInEitherOrderOfTheEnds) {
  EXPECT_NEAR(root_between(cosine, 1, 2, cosine(1), cosine(2)), kPi / 2, 4e-15);
  EXPECT_EQ(root_between(cosine, 2, 1, cosine(2), cosine(1)),
            root_between(cosine, 1, 2, cosine(1), cosine(2)));
  EXPECT_NEAR(root_between(cosine, 1, 2, cosine(1), cosine(2), 1e-6), kPi / 2, 1e-6 * kPi);
}

TEST(RootBetween, AnEndThatIsTheRootIsIt) {
  const auto identity = [](double x) { return x; };
  EXPECT_EQ(root_between(identity, 0, 1, 0, 1), 0);
  EXPECT_EQ(root_between(identity, -1, 0, -1, 0), 0);
}

TEST(FirstCrossing, IsTheNearestOneThatTheStepsSee) {
  EXPECT_NEAR(first_crossing(cosine, 0, 1, 0.3, 100), kPi / 2, 4e-15);
  EXPECT_NEAR(first_crossing(cosine, 0, 1, -0.3, 100), -kPi / 2, 4e-15);
  EXPECT_TRUE(std::isnan(first_crossing(cosine, 0, 1, 0.3, 1.5)));
  // Steps of a full period miss the crossings in between.
  EXPECT_TRUE(std::isnan(first_crossing(cosine, 0, 1, kTwoPi, 100)));
}

}  // namespace
}  // namespace aberfit
