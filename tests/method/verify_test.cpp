#include "aberfit/method/verify.h"

#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/method/constants.h"

namespace aberfit {
namespace {

TEST(EnsembleDraws, MakeTheMeanAsSureAsTheMarginNeeds) {
  // The margin holds 4.62 standard errors of 1.5 spread/sqrt(draws), in whole groups.
  for (const double spread : {1.0, 1.5, 2.5, 3.0}) {
    const int draws = ensemble_draws(spread);
    EXPECT_EQ(draws % law::kGroups, 0);
    EXPECT_LE(1.5 * 4.62 * spread / std::sqrt(double(draws)), 1 + 1e-12);
    EXPECT_GT(1.5 * 4.62 * spread / std::sqrt(double(draws - law::kGroups)), 1 - 1e-12);
  }
  EXPECT_EQ(ensemble_draws(1e-6), 2 * law::kGroups);
  EXPECT_EQ(ensemble_draws(50), law::kMostGroupDraws * law::kGroups);
  EXPECT_EQ(ensemble_draws(NAN), law::kMostGroupDraws * law::kGroups);
}

}  // namespace
}  // namespace aberfit
