#pragma once
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace aberfit::test {

/// Compares a result.json with the expected.json of a reference study: verdict, verdict by waves, status,
/// warnings, values.
inline void expect_what_the_file_says(const nlohmann::json& result, const std::string& folder) {
  std::ifstream file(folder + "/expected.json");
  const nlohmann::json expected = nlohmann::json::parse(file);
  EXPECT_EQ(result["equivalence"]["verdict"], expected["verdict"]);
  EXPECT_EQ(result["fit"]["status"], expected["status"]);
  if (expected.contains("light")) {
    EXPECT_EQ(result["equivalence"]["light"]["verdict"], expected["light"]);
  }
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

}  // namespace aberfit::test
