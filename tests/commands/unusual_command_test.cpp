// Messages about unlikely numbers: exit 2 with the key if nothing can be computed, else one line in the text
// and in the JSON.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using namespace test;
using nlohmann::ordered_json;

constexpr const char* kStudy = R"({ "aberfit": 1, "mirror": { "focal_length": "1.5 m" },
  "aperture": { "shape": "circle", "diameter": "0.25 m" }, "light": { "wavelength": "550 nm" },
  "roughness": { "psd": { "model": "k-correlation", "rms": "8 nm", "B": "30 mm", "exponent": 3, "f_min": "4 /m",
    "f_max": "200 /m" } },
  "solve": { "for": ["/roughness/psd/rms"], "so_that": { "ee80_diameter": "<= 30 um" } },
  "vary": { "over": { "/roughness/psd/rms": ["8 nm", "9 nm", "10 nm"] } }, "output": { "pictures": "none" } })";

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t found = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
  return found;
}

std::vector<std::string> unusual_in(const ordered_json& json) {
  std::vector<std::string> messages;
  for (const auto& warning : json["warnings"])
    if (warning["code"] == "unusual") messages.push_back(warning["message"]);
  return messages;
}

class UnusualNumbersOfAStudy : public ::testing::Test {
 protected:
  UnusualNumbersOfAStudy() { folder_.write("s.json", kStudy); }
  int run(const std::string& arguments) { return run_program(folder_, arguments); }
  std::string out() const { return read_file(folder_.file("stdout.txt")); }
  std::string err() const { return read_file(folder_.file("stderr.txt")); }
  ScratchFolder folder_;
};

// Each of these once gave exit 3 with a sentence about light, slopes or frequencies.
TEST_F(UnusualNumbersOfAStudy, AreExitCodeTwoWithTheKeyWhereNothingCanBeComputed) {
  const struct {
    const char *change, *pointer, *value, *meant;
  } kCases[] = {
      {"/aperture/diameter=250", "/aperture/diameter", "250 m; a wrong unit?", "a diameter of 250 mm"},
      {"/mirror/focal_length=1.5 mm", "/mirror/focal_length", "1.5 mm; a wrong unit?",
       "a focal length of 1.5 m"},
      {R"(/aperture={"shape": "annulus", "diameter": 240, "inner_diameter": 60})", "/aperture/diameter",
       "240 m; a wrong unit?", "a diameter of 240 mm"},
      {R"(/mirror/zernike={"noll": {"11": "50 mm"}})", "/mirror/zernike/noll/11", "50 mm; a wrong unit?",
       "a height of 50 um"},
      {R"(/roughness/psd={"model": "uniform", "rms": "8 nm", "f_min": "4 /um", "f_max": "200 /um"})",
       "/roughness/psd/f_max", "200 /um; a wrong unit?", "a highest frequency of 200 /mm"},
      {R"(/target/statistics={"ee80": {"planes": ["-1.6 m"]}})", "/target/statistics/ee80/planes/0",
       "-1.6 m; a wrong unit?", "a plane at -1.6 mm"}};
  for (const auto& one : kCases) {
    EXPECT_EQ(run("check s.json --set '" + std::string(one.change) + "'"), 2) << one.change;
    EXPECT_NE(err().find(std::string(one.pointer) + ": found " + one.value), std::string::npos) << err();
    EXPECT_NE(err().find(one.meant), std::string::npos) << err();
  }
}

TEST_F(UnusualNumbersOfAStudy, AreOneLineWhereSomethingCanBeComputed) {
  const std::string slow = " --set /mirror/focal_length=1500 --json";
  for (const std::string command : {"check s.json", "solve s.json -o out"}) {
    EXPECT_LT(run(command + slow), 2) << err();
    const std::vector<std::string> said = unusual_in(ordered_json::parse(out()));
    ASSERT_EQ(said.size(), 1u) << command;
    EXPECT_NE(said[0].find("/mirror/focal_length is 1.5 km: an f-number of 6000"), std::string::npos)
        << said[0];
    EXPECT_NE(said[0].find("a focal length of 1.5 m"), std::string::npos) << said[0];
    run(command + " --json");
    EXPECT_TRUE(unusual_in(ordered_json::parse(out())).empty()) << command;
  }
  EXPECT_LT(run("check s.json --set /mirror/focal_length=1500"), 2);
  EXPECT_EQ(count(out(), "[unusual] "), 1u) << out();
}

TEST_F(UnusualNumbersOfAStudy, AreToldOnceOfASweep) {
  EXPECT_EQ(run("sweep s.json -o all --set /mirror/focal_length=1500"), 0) << err();
  EXPECT_EQ(count(out(), "[unusual] "), 1u) << out();
  EXPECT_NE(out().find("3 of 3 cases"), std::string::npos) << out();
  EXPECT_EQ(count(read_file(folder_.file("all/cases.csv")), "unusual"), 3u);
  const ordered_json result = ordered_json::parse(read_file(folder_.file("all/result.json")));
  ASSERT_EQ(unusual_in(result).size(), 1u);
  EXPECT_NE(unusual_in(result)[0].find("a focal length of 1.5 m"), std::string::npos);
  // Only one case is unusual; the study is ordinary.
  EXPECT_EQ(
      run(R"(sweep s.json -o one --set '/vary={"over": {"/mirror/focal_length": ["1.5 m", "1.5 km"]}}')"), 0)
      << err();
  EXPECT_NE(out().find("1 of 2 cases have an unusual number. Case 1:"), std::string::npos) << out();
  // The varied value replaces the study's own value, which is not among the cases.
  EXPECT_EQ(run("sweep s.json -o none --set '/roughness/psd/rms=200 um'"), 0) << err();
  EXPECT_EQ(count(out(), "unusual"), 0u) << out();
}

}  // namespace
}  // namespace aberfit
