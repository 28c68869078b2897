// Rows of published numbers: what their expressions mean and how their verdicts come about.
#include "aberfit/study/published.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "aberfit/core/errors.h"
#include "aberfit/study/read_study.h"
#include "study/study_texts.h"

namespace aberfit {
namespace {

Study study_with(const std::string& rows) {
  return parse_study(test::changed("/verify", R"({"published": )" + rows + "}"), "study.json");
}
// The only row that says nothing but `keys`, compared.
PublishedComparison compared(const std::string& keys, const Quantities& quantities = {}) {
  return compare_published(study_with(R"([{"label": "x", )" + keys + "}]"), quantities).at(0);
}
double value_of(const std::string& expression) {
  return compared(R"("expression": ")" + expression + '"', {{"a.b_m", 3}, {"c@ring=ee50", 5}}).ours;
}
std::string error_of(const std::string& keys) {
  try {
    compared(keys);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Expression, FollowsTheUsualPrecedence) {
  EXPECT_EQ(value_of("1 + 2*3^2/6 - 4"), 0);
  EXPECT_EQ(value_of("-2^2"), -4);
  EXPECT_EQ(value_of("2^-1"), 0.5);
  EXPECT_EQ(value_of("2^3^2"), 512);  // to the right
  EXPECT_EQ(value_of("8/4/2"), 1);    // to the left
  EXPECT_EQ(value_of("-(1 - 3)*1.5e-1"), 0.3);
  EXPECT_EQ(value_of("a.b_m*c_ring_ee50"), 15);
  EXPECT_EQ(value_of("max(2, min(7, 5))"), 5);
  EXPECT_EQ(value_of("(1 < 2)*(3 >= 3) + (2 > 2) + (1 <= 0)"), 1);
  EXPECT_DOUBLE_EQ(value_of("sqrt(2)*cos(pi/4) + asin(1)/pi + log(exp(3)) + log10(100) + abs(-1)"),
                   1 + 0.5 + 3 + 2 + 1);
  EXPECT_DOUBLE_EQ(value_of("180*3600*arcsec"), std::acos(-1.0));
}

TEST(Expression, SaysWhatIsWrongWithIt) {
  EXPECT_NE(error_of(R"("expression": "2 +")").find("/verify/published/0/expression"), std::string::npos);
  EXPECT_NE(error_of(R"("expression": "(1")").find("')' at character 3"), std::string::npos);
  EXPECT_NE(error_of(R"("expression": "1 2")").find("an operator or the end"), std::string::npos);
  EXPECT_NE(error_of(R"-("expression": "system(1)")-").find("no function"), std::string::npos);
  EXPECT_NE(error_of(R"("holds": "ours <")").find("/verify/published/0/holds"), std::string::npos);
  EXPECT_NE(error_of(R"("expression": "unknown")").find("\"unknown\""), std::string::npos);
  EXPECT_NE(error_of(R"("expression": "1", "quantity": "a")").find("one of quantity"), std::string::npos);
  EXPECT_NE(error_of(R"("verdict": "perhaps")").find("not-reproducible"), std::string::npos);
  EXPECT_NE(error_of(R"("printed": "2.5", "value": 2.6)").find("/verify/published/0/value"),
            std::string::npos);
  const std::string deep = std::string(100000, '(');
  EXPECT_NE(error_of(R"("expression": ")" + deep + '"').find("nested"), std::string::npos);
}

TEST(PublishedRow, HoldsToItsLastDigit) {
  EXPECT_DOUBLE_EQ(half_last_digit("1.57e-5"), 0.005e-5);
  EXPECT_DOUBLE_EQ(half_last_digit("655"), 0.5);
  EXPECT_DOUBLE_EQ(half_last_digit("-1.13e3"), 5);
  EXPECT_DOUBLE_EQ(half_last_digit("2.8"), 0.05);
  EXPECT_TRUE(std::isnan(half_last_digit("about 3")));
  const auto verdict = [](const std::string& ours, const std::string& rest = "") {
    return compared(R"("printed": "1.57e-5", "expression": ")" + ours + '"' + rest).verdict;
  };
  EXPECT_EQ(verdict("1.5749e-5"), "holds");
  EXPECT_EQ(verdict("1.575e-5"), "holds");  // the bound itself
  EXPECT_EQ(verdict("1.5751e-5"), "fails");
  EXPECT_EQ(verdict("1.5649e-5"), "fails");
  EXPECT_EQ(verdict("1.6e-5", R"(, "within": 0.02)"), "holds");
  EXPECT_EQ(verdict("1.61e-5", R"(, "within": 0.02)"), "fails");
  EXPECT_EQ(verdict("15.7e-6", R"(, "scale": 1e-3)"), "fails");
  EXPECT_EQ(verdict("15.7e-9", R"(, "scale": 1e-3)"), "holds");
}

TEST(PublishedRow, ItsVerdictIsThatOfTheComparisonWhereThereIsOne) {
  // What it would be called if it held, and what it is called because it does not.
  EXPECT_EQ(compared(R"("printed": "3", "expression": "3.1", "verdict": "reading")").verdict, "reading");
  EXPECT_EQ(compared(R"("printed": "3", "expression": "4", "verdict": "reading")").verdict, "fails");
  EXPECT_EQ(compared(R"("printed": "3", "expression": "3", "verdict": "fails")").verdict, "holds");
  // Without one it is what the row says; nothing where it says nothing.
  EXPECT_EQ(compared(R"("printed": "qualitative", "expression": "3", "verdict": "untested")").verdict,
            "untested");
  EXPECT_EQ(compared(R"("printed": "3")").verdict, "");
  // A condition goes before digits; it sees ours and printed in the printed unit.
  EXPECT_EQ(
      compared(R"("printed": "2", "scale": 0.01, "expression": "0.0189", "holds": "ours < printed")").verdict,
      "holds");
  EXPECT_EQ(
      compared(R"("printed": "2", "scale": 0.01, "expression": "0.0211", "holds": "ours < printed")").verdict,
      "fails");
}

TEST(PublishedRow, KnowsThePrintedValuesOfTheOthers) {
  const Study study = study_with(
      R"-([{"label": "x", "id": "gradient-x", "printed": "3", "scale": 1e-3, "unit": "mm"},
          {"label": "y", "id": "gradient-y", "printed": "4e-3"},
          {"label": "total", "printed": "5", "scale": 1e-3,
           "expression": "sqrt(printed.gradient_x^2 + printed.gradient_y^2)"}])-");
  const auto rows = compare_published(study, {});
  EXPECT_DOUBLE_EQ(rows.at(2).ours, 5);
  EXPECT_EQ(rows.at(2).verdict, "holds");
  EXPECT_EQ(rows.at(2).from, "sqrt(printed.gradient_x^2 + printed.gradient_y^2)");
  EXPECT_EQ(rows.at(0).printed_text, "3");
}

TEST(PublishedRow, IsWrittenIntoTheResolvedStudyAsItWasRead) {
  const std::string row =
      R"([{"id": "a", "section": "5", "label": "x", "expression": "2*pi", "printed": "6.28", "derived": true,
           "unit": "m", "within": 0.01, "holds": "ours < 7", "verdict": "reading", "picture": "mirror",
           "reading": "so"}])";
  const nlohmann::ordered_json once = resolved_study(study_with(row));
  EXPECT_EQ(resolved_study(parse_study(once.dump(), "study.json")), once);
  EXPECT_EQ(once["verify"]["published"][0]["printed"], "6.28");
  EXPECT_EQ(once["verify"]["published"][0]["value"], 6.28);
}

}  // namespace
}  // namespace aberfit
