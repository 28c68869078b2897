#include "aberfit/core/smooth_number.h"

#include <gtest/gtest.h>

namespace aberfit {
namespace {

// Direct definition: checks every prime divisor above `largest`.
bool has_larger_prime_factor(int n, int largest) {
  for (int p = largest + 1; p <= n; ++p) {
    bool prime = true;
    for (int d = 2; d * d <= p; ++d) prime = prime && p % d != 0;
    if (prime && n % p == 0) return true;
  }
  return false;
}

TEST(SmoothNumber, HasNoLargerPrimeFactor) {
  for (int n = 1; n <= 500; ++n)
    for (const int largest : {5, 7})
      EXPECT_EQ(is_smooth(n, largest), !has_larger_prime_factor(n, largest)) << n;
}

TEST(SmoothNumber, TheNearestAreOnEitherSide) {
  EXPECT_EQ(smooth_up_to(1021), 1008);
  EXPECT_EQ(smooth_from(1021), 1024);
  EXPECT_EQ(smooth_up_to(96), 96);
  EXPECT_EQ(smooth_from(96), 96);
  EXPECT_EQ(smooth_up_to(0), 0);
}

}  // namespace
}  // namespace aberfit
