#include "aberfit/core/random.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <set>
#include <string_view>
#include <vector>

#include "../../src/core/normal_kernel.h"

namespace aberfit {
namespace {

// Philox4x64-10 written independently from Salmon, Moraes, Dror and Shaw, Parallel Random Numbers: As Easy as
// 1, 2, 3 (2011), section 3.3. It has ten rounds of two multiplications, and two Weyl sequences change the
// key in between.
using Words = std::array<std::uint64_t, 4>;
struct Product {
  std::uint64_t high, low;
};
Product product(std::uint64_t a, std::uint64_t b) {
  const std::uint64_t half = 0xffffffff, a0 = a & half, a1 = a >> 32, b0 = b & half, b1 = b >> 32;
  const std::uint64_t middle = a1 * b0 + (a0 * b0 >> 32), other = a0 * b1 + (middle & half);
  return {a1 * b1 + (middle >> 32) + (other >> 32), a * b};
}
Words philox(Words c, std::array<std::uint64_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const Product p = product(0xd2e7470ee14c6c93, c[0]), q = product(0xca5a826395121157, c[2]);
    c = {q.high ^ c[1] ^ key[0], q.low, p.high ^ c[3] ^ key[1], p.low};
    key[0] += 0x9e3779b97f4a7c15;  // golden ratio
    key[1] += 0xbb67ae8584caa73b;  // sqrt(3) - 1
  }
  return c;
}

// 64-bit FNV-1a values of known words (Fowler, Noll, Vo, Eastlake, draft-eastlake-fnv).
constexpr std::uint64_t kHashOfNothing = 0xcbf29ce484222325, kHashOfFoobar = 0x85944171f73967e8;

// The lines "philox4x64 10" of the file kat_vectors in Random123.
TEST(RandomStream, TheTwinOfTheseTestsHasThePublishedVectors) {
  const std::uint64_t ones = ~std::uint64_t(0);
  EXPECT_EQ(philox({}, {}),
            (Words{0x16554d9eca36314c, 0xdb20fe9d672d0fdc, 0xd7e772cee186176b, 0x7e68b68aec7ba23b}));
  EXPECT_EQ(philox({ones, ones, ones, ones}, {ones, ones}),
            (Words{0x87b092c3013fe90b, 0x438c3c67be8d0224, 0x9cc7d7c69cd777b6, 0xa09caebf594f0ba0}));
  EXPECT_EQ(philox({0x243f6a8885a308d3, 0x13198a2e03707344, 0xa4093822299f31d0, 0x082efa98ec4e6c89},
                   {0x452821e638d01377, 0xbe5466cf34e90c6c}),
            (Words{0xa528f45403e61d95, 0x38c72dbd566e9788, 0xa5a1610e72fd18b5, 0x57bd43b5e52b7fe6}));
}

// The counter is the index, the key is seed and hash of the name.
TEST(RandomStream, IsPhiloxOfIndexSeedAndName) {
  struct Named {
    std::string_view name;
    std::uint64_t hash;
  };
  constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();  // log, root, cos
  for (const Named& named : {Named{"", kHashOfNothing}, Named{"foobar", kHashOfFoobar}})
    for (const std::uint64_t seed : {std::uint64_t(0), std::uint64_t(1), ~std::uint64_t(0)}) {
      const RandomStream stream(seed, named.name);
      for (const std::uint64_t index : {std::uint64_t(0), std::uint64_t(1), std::uint64_t(1) << 40}) {
        const Words words = philox({index, 0, 0, 0}, {seed, named.hash});
        EXPECT_EQ(stream.bits(index), words[0]);
        // The centres of 2^53 intervals.
        const long double u = (static_cast<long double>(words[0] >> 11) + 0.5L) * 0x1p-53L,
                          v = (static_cast<long double>(words[1] >> 11) + 0.5L) * 0x1p-53L;
        EXPECT_EQ(stream.uniform_pair(index), (std::array<double, 2>{double(u), double(v)}));
        EXPECT_EQ(stream.uniform(index), double(u));
        const long double radius = std::sqrt(-2 * std::log(u)),
                          angle = 2 * std::numbers::pi_v<long double> * v;
        const auto [a, b] = stream.normal_pair(index);
        EXPECT_NEAR(a, double(radius * std::cos(angle)), kRounding * double(radius));
        EXPECT_NEAR(b, double(radius * std::sin(angle)), kRounding * double(radius));
        EXPECT_EQ(stream.normal(index), a);
      }
    }
}

// Numbers of two streams, computed with Python. A change of them changes every result of every study.
TEST(RandomStream, NamedStreamsKeepTheirNumbers) {
  const RandomStream draw(1, "coefficient-draw"), scramble(20240229, "sobol-scramble");
  EXPECT_EQ(draw.bits(0), 0x18da0678b6758e4fu);
  EXPECT_EQ(draw.bits(1), 0xcd814c9782d675d2u);
  EXPECT_EQ(draw.uniform_pair(0), (std::array<double, 2>{0x1.8da0678b6758cp-4, 0x1.0c18c386b74b8p-1}));
  EXPECT_NEAR(draw.normal_pair(0)[0], -2.135992977696402, 2e-15);
  EXPECT_NEAR(draw.normal_pair(0)[1], -0.319436512534579, 2e-15);
  const std::uint64_t far = (std::uint64_t(1) << 40) + 7;
  EXPECT_EQ(scramble.bits(far), 0x8a17212c03ac558cu);
  EXPECT_EQ(scramble.uniform_pair(far), (std::array<double, 2>{0x1.142e42580758ap-1, 0x1.1fcdbce8dd6f2p-1}));
  EXPECT_NEAR(scramble.normal_pair(far)[0], -1.0275420987010249, 2e-15);
  EXPECT_NEAR(scramble.normal_pair(far)[1], -0.42272421679287575, 2e-15);
}

TEST(RandomStream, SeedNameAndIndexEachMakeOtherNumbers) {
  std::set<std::uint64_t> seen;
  for (const char* name : {"", "a", "b", "ab", "ba"})
    for (const std::uint64_t seed : {0, 1, 2})
      for (std::uint64_t index = 0; index < 4; ++index) seen.insert(RandomStream(seed, name).bits(index));
  EXPECT_EQ(seen.size(), 5u * 3 * 4);
}

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

// Tests the ends of (0, 1): the smallest numbers of 53 bits, and those next to 1, where the logarithm is
// small.
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
