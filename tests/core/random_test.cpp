#include "aberfit/core/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "../../src/core/normal_kernel.h"

namespace aberfit {
namespace {

TEST(RandomStream, ManyNormalsAreThoseOfOneAfterTheOther) {
  const RandomStream stream(5, "many");
  for (const int count : {1, 7, 8, 255, 256, 1000}) {
    std::vector<double> one(static_cast<std::size_t>(count)), other(one.size());
    stream.normal_pairs(17, count, one.data(), other.data());
    for (int i = 0; i < count; ++i) {
      const auto pair = stream.normal_pair(17 + std::uint64_t(i));
      EXPECT_NEAR(one[std::size_t(i)], pair[0], 4e-15 * std::hypot(pair[0], pair[1]));
      EXPECT_NEAR(other[std::size_t(i)], pair[1], 4e-15 * std::hypot(pair[0], pair[1]));
    }
  }
}

// The ends of (0, 1): numbers that 53 bits can hold there, and those beside 1, where the logarithm is small.
TEST(RandomStream, BoxMullerIsRightAtTheEnds) {
  for (const InstructionSet set :
       {InstructionSet::kBaseline, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (!is_supported(set)) continue;
    const std::vector<double> ends{
        0x1p-54, 0x1.8p-53, 1e-9, 0.25, 0.70710678118654746, 0.70710678118654757, 1 - 0x1p-30, 1 - 0x1p-53};
    std::vector<double> u = ends, v{0.01, 0.24, 0.26, 0.5, 0.74, 0.76, 0.99, 0.125};
    const std::vector<double> turns = v;
    internal::box_muller(set, 8, u.data(), v.data());
    for (std::size_t i = 0; i < 8; ++i) {
      const double radius = std::sqrt(-2 * std::log(ends[i]));
      EXPECT_NEAR(u[i], radius * std::cos(2 * M_PI * turns[i]), 6e-15 * radius) << i;
      EXPECT_NEAR(v[i], radius * std::sin(2 * M_PI * turns[i]), 6e-15 * radius) << i;
    }
  }
}

}  // namespace
}  // namespace aberfit
