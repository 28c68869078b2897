// Comments in .jsonc studies, the explanations that they give, and messages about missing blocks.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "aberfit/core/errors.h"
#include "aberfit/study/read_study.h"
#include "study_texts.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;

// A study whose focal length is `focal_length`, with comments wherever one may stand.
std::string commented(const std::string& focal_length) {
  return R"(// a comment before anything
{
  "aberfit": 1, // one behind a value
  /* one over
     two lines */
  "title": "no // comment, and no /* comment */",
  "mirror": { "focal_length": /* between */ )" +
         focal_length + R"( }, // { "focal_length": "1 m" }
  "aperture": { "shape": "circle", "diameter": "0.4 m" },
  "light": { "wavelength": "632.8 nm" },
  "roughness": { "psd": { "model": "uniform", "rms": "100 nm", "f_min": "2.5 /m", "f_max": "39.92 /m" } }
} // and one at the end
)";
}

std::string refusal(const std::string& text, const std::string& path) {
  try {
    parse_study(text, path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing refused";
}

TEST(CommentedStudy, IsTheStudyWithoutItsComments) {
  const Study study = parse_study(commented("\"2.8 m\""), "study.jsonc");
  EXPECT_EQ(study.title, "no // comment, and no /* comment */");
  const std::string plain = test::changed("/title", '"' + study.title + '"');
  EXPECT_EQ(resolved_study(study), resolved_study(parse_study(plain, "study.json")));
}

TEST(CommentedStudy, HasItsErrorsWhereTheTextHasThem) {
  const std::string unit = refusal(commented("\"2.8 furlong\""), "study.jsonc");
  EXPECT_NE(unit.find("study.jsonc: /mirror/focal_length: "), std::string::npos) << unit;
  // A syntax error is reported with line and column of the character in the text, which we count here.
  const std::string text = commented("2.8.1");
  const std::size_t at = text.find("2.8.1") + 3;
  const std::size_t line = 1 + std::size_t(std::count(text.begin(), text.begin() + long(at), '\n'));
  const std::size_t column = at - text.rfind('\n', at);
  const std::string syntax = refusal(text, "study.jsonc");
  EXPECT_NE(syntax.find(fmt::format("line {}, column {},", line, column)), std::string::npos) << syntax;
  EXPECT_NE(refusal(commented("1 /* open"), "study.jsonc").find("missing closing '*/'"), std::string::npos);
  EXPECT_NE(refusal(commented("1, \"focal_length\": 2"), "study.jsonc").find("/mirror/focal_length"),
            std::string::npos);
}

TEST(CommentedStudy, HasToBeCalledJsonc) {
  for (const char* path : {"study.json", "standard input", "study"})
    for (const auto& [text, line] : {std::pair<std::string, int>{commented("1"), 1},
                                     std::pair<std::string, int>{"{ \"aberfit\": 1,\n /* x */ }", 2}}) {
      const std::string said = refusal(text, path);
      EXPECT_NE(said.find(fmt::format("a comment at line {}, column ", line)), std::string::npos) << said;
      EXPECT_NE(said.find("name the file .jsonc"), std::string::npos) << said;
    }
  EXPECT_EQ(refusal("{ \"aberfit\": / 1 }", "study.json").find("a comment"), std::string::npos);
}

TEST(StudyForPeople, HasADescriptionThatGoesWithItAndAPlaceOfItsSchema) {
  const std::string text = "Who asked for it.\nAnd why: \u03c3 = 20 nm.";
  ordered_json with = ordered_json::parse(test::kMinimalStudy);
  with["description"] = text;
  with["$schema"] = "./aberfit.schema.json";
  const Study study = parse_study(with.dump(), "study.json");
  EXPECT_EQ(study.description, text);
  const ordered_json resolved = resolved_study(study);
  EXPECT_EQ(resolved["description"], text);
  EXPECT_EQ(resolved["$schema"], "./aberfit.schema.json");
  EXPECT_EQ(resolved_study(parse_study(resolved.dump(), "study.json")), resolved);
  EXPECT_FALSE(resolved_study(parse_study(test::kMinimalStudy, "study.json")).contains("description"));
  EXPECT_NE(refusal(test::changed("/description", "5"), "study.json").find("/description"),
            std::string::npos);
}

// The examples in the message are exactly the missing blocks.
TEST(MissingBlocks, AreToldTogetherWithExamplesThatMakeAStudy) {
  const std::string said = refusal("{\"aberfit\": 1}", "study.json");
  const std::string begin = "study.json: missing; a study needs ";
  ASSERT_TRUE(said.starts_with(begin)) << said;
  const std::string study = "{\"aberfit\": 1, " + said.substr(begin.size()) + "}";
  EXPECT_EQ(refusal(study, "study.json"), "nothing refused") << study;
  for (const char* block : {"mirror", "aperture", "light", "roughness"})
    EXPECT_TRUE(ordered_json::parse(study).contains(block)) << block;
  EXPECT_TRUE(refusal("{}", "study.json").starts_with(begin + "\"aberfit\": 1, \"mirror\""));
}

TEST(MissingBlocks, AreToldByTheKeyWhereItIsOne) {
  EXPECT_EQ(
      refusal(test::changed("/mirror/focal_length", ""), "study.json"),
      "study.json: /mirror/focal_length: missing; mirror needs \"focal_length\": \"2.8 m\" (paraxial focal "
      "length [m])");
  EXPECT_EQ(refusal(test::changed("/aperture", R"({"shape": "annulus"})"), "study.json"),
            "study.json: /aperture: missing; aperture needs \"diameter\": \"0.4 m\", \"inner_diameter\": "
            "\"0.1 m\"");
  const std::string shape = refusal(test::changed("/aperture", R"({"diameter": "0.4 m"})"), "study.json");
  EXPECT_NE(shape.find("/aperture/shape: missing; aperture needs \"shape\", one of \"circle\""),
            std::string::npos)
      << shape;
}

}  // namespace
}  // namespace aberfit
