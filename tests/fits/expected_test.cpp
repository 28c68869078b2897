#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "aberfit/commands/run.h"
#include "aberfit/study/read_study.h"

using namespace aberfit;

class ReferenceStudy : public testing::TestWithParam<const char*> {};

TEST_P(ReferenceStudy, GivesWhatItsExpectedFileSays) {
  const std::string folder = std::string(ABERFIT_SOURCE_DIR "/fits/") + GetParam();
  std::ifstream file(folder + "/expected.json");
  const nlohmann::json expected = nlohmann::json::parse(file);
  const Study study = read_study(folder + "/study.json");
  RunOptions options;
  options.threads = 2;
  const nlohmann::json result = to_json(run_fit(study, options), resolved_study(study));
  EXPECT_EQ(result["equivalence"]["verdict"], expected["verdict"]);
  EXPECT_EQ(result["fit"]["status"], expected["status"]);
  for (const auto& code : expected["warnings"]) {
    bool found = false;
    for (const auto& warning : result["warnings"]) found = found || warning["code"] == code;
    EXPECT_TRUE(found) << code;
  }
  ASSERT_FALSE(expected["values"].empty());
  for (const auto& row : expected["values"]) {
    const auto& found = result.at(nlohmann::json::json_pointer(row["at"].get<std::string>()));
    EXPECT_NEAR(found.get<double>() / row["value"].get<double>(), 1.0, row["tolerance"].get<double>()) << row;
  }
}

INSTANTIATE_TEST_SUITE_P(Fits, ReferenceStudy,
                         testing::Values("paper-physical", "paper-harvey-shack", "paper-published-values",
                                         "spherical", "measured-zygo", "smooth-waves"),
                         [](const auto& study) {
                           std::string name = study.param;
                           std::erase(name, '-');
                           return name;
                         });
