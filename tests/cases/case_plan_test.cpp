// Plans against independent definitions of a grid and a Sobol sequence; ranges against closed forms.
#include "aberfit/cases/case_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"

namespace aberfit {
namespace {

VaryAxis list(const std::string& pointer, const std::vector<std::string>& values) {
  return {pointer, values, "", "", 0, "linear"};
}
VaryAxis range(const std::string& from, const std::string& to, int count, const std::string& spacing) {
  return {"/mirror/conic", {}, from, to, count, spacing};
}
VarySpec grid(const std::vector<VaryAxis>& axes, int realisations = 1) {
  VarySpec vary;
  vary.axes = axes;
  vary.realisations = realisations;
  return vary;
}
std::string text(const CaseValues& values) {
  std::string all;
  for (const auto& [pointer, value] : values) all += pointer + "=" + value + ";";
  return all;
}

TEST(CasePlan, OfAGridHasEveryValueWithEveryOtherAndEachOnce) {
  const CasePlan plan(grid({list("/a", {"1", "2", "3"}), list("/b", {"\"x\"", "\"y\""})}, 2), 7, "s.json");
  ASSERT_EQ(plan.size(), 12u);
  EXPECT_EQ(plan.pointers(), (std::vector<std::string>{"/a", "/b", "/fit/seed"}));
  std::size_t index = 0;
  for (const char* a : {"1", "2", "3"})
    for (const char* b : {"\"x\"", "\"y\""})
      for (const char* seed : {"7", "8"})
        EXPECT_EQ(text(plan.at(index++)), std::string("/a=") + a + ";/b=" + b + ";/fit/seed=" + seed + ";");
}

TEST(CasePlan, RangesAreTheirClosedForms) {
  EXPECT_EQ(range_value(range("\"10 nm\"", "\"40 nm\"", 4, "linear"), 1.0 / 3), "\"20 nm\"");
  EXPECT_EQ(range_value(range("\"1 nm\"", "\"100 nm\"", 3, "log"), 0.5), "\"10 nm\"");
  EXPECT_EQ(range_value(range("0.1", "0.3", 3, "linear"), 0.5), "0.2");  // not 0.20000000000000001
  EXPECT_EQ(range_value(range("4", "9", 3, "integers"), 0.5), "7");
  // The end has another unit of the same kind.
  EXPECT_EQ(range_value(range("\"400 nm\"", "\"1 um\"", 3, "linear"), 0.5), "\"700 nm\"");
  EXPECT_EQ(range_value(range("\"400 nm\"", "\"1 um\"", 3, "linear"), 1), "\"1000 nm\"");
  for (const VaryAxis& wrong :
       {range("\"400 nm\"", "1", 3, "linear"), range("\"400 nm\"", "\"1 /m\"", 3, "linear"),
        range("0", "1", 3, "log"), range("1", "1", 3, "linear"), range("\"wide\"", "1", 3, "linear")})
    EXPECT_THROW(CasePlan(grid({wrong}), 1, "s.json"), InputError) << wrong.from << " " << wrong.to;
}

TEST(CasePlan, ARangeInAGridHasBothEnds) {
  const CasePlan plan(grid({range("\"1 nm\"", "\"16 nm\"", 5, "log")}), 1, "s.json");
  EXPECT_EQ(plan.values(0),
            (std::vector<std::string>{"\"1 nm\"", "\"2 nm\"", "\"4 nm\"", "\"8 nm\"", "\"16 nm\""}));
}

// Sobol's law: of the first 2^k points each of 2^k equal intervals of a coordinate holds one. So does every
// elementary box of area 2^-k of the first two coordinates ((0, k, 2)-net). A digital shift keeps both.
TEST(CasePlan, SobolPointsAreANet) {
  constexpr int kPower = 8, kPoints = 1 << kPower;
  for (const std::uint64_t seed : {1u, 2u}) {
    const auto points = shifted_sobol(kPoints, 5, seed);
    for (std::size_t d = 0; d < 5; ++d) {
      std::set<int> cells;
      for (const auto& point : points) {
        EXPECT_TRUE(point[d] >= 0 && point[d] < 1);
        cells.insert(int(point[d] * kPoints));
      }
      EXPECT_EQ(cells.size(), std::size_t(kPoints)) << d;
    }
    for (int k = 0; k <= kPower; ++k) {
      std::set<std::pair<int, int>> cells;
      for (const auto& point : points)
        cells.insert({int(point[0] * (1 << k)), int(point[1] * (1 << (kPower - k)))});
      EXPECT_EQ(cells.size(), std::size_t(kPoints)) << k;
    }
  }
  EXPECT_NE(shifted_sobol(4, 2, 1), shifted_sobol(4, 2, 2));
}

TEST(CasePlan, SobolCasesSpreadOverRangesListsAndWholeNumbers) {
  VarySpec vary = grid({range("\"10 nm\"", "\"20 nm\"", 0, "linear"), list("/b", {"1", "2"})});
  vary.axes.push_back(range("2", "5", 0, "integers"));
  vary.design = VaryDesign::kSobol;
  vary.cases = 64;
  const CasePlan plan(vary, 1, "s.json");
  ASSERT_EQ(plan.size(), 64u);
  std::map<std::string, int> second, third;
  for (std::size_t k = 0; k < plan.size(); ++k) {
    const CaseValues at = plan.at(k);
    const double rms =
        parse_quantity(nlohmann::json::parse(at[0].second).get<std::string>(), Dimension::kLength);
    EXPECT_TRUE(rms >= 10e-9 && rms < 20e-9) << at[0].second;
    ++second[at[1].second], ++third[at[2].second];
  }
  EXPECT_EQ(second, (std::map<std::string, int>{{"1", 32}, {"2", 32}}));
  EXPECT_EQ(third, (std::map<std::string, int>{{"2", 16}, {"3", 16}, {"4", 16}, {"5", 16}}));
  // Lists alone have no more cases than combinations, each once.
  vary.axes = {list("/a", {"1", "2", "3"}), list("/b", {"1", "2"})};
  EXPECT_EQ(CasePlan(vary, 1, "s.json").size(), 6u);
}

}  // namespace
}  // namespace aberfit
