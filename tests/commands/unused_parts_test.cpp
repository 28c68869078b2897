// A command says in one line which parts of a study it does not use.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;
using test::read_file;

class UnusedParts : public testing::Test {
 protected:
  const test::ScratchFolder folder_;

  // The `contributors-not-used` messages for this `with` block.
  std::vector<std::string> said(const std::string& command, const std::string& with,
                                const std::string& run = "check") const {
    ordered_json study = ordered_json::parse(R"({"aberfit": 1, "mirror": {"focal_length": 2.8},
      "aperture": {"shape": "circle", "diameter": 0.4}, "light": {"wavelength": 632.8e-9},
      "roughness": {"psd": {"model": "uniform", "rms": 20e-9, "f_min": 2.5, "f_max": 6}},
      "target": {"statistics": {"rms_height": {}}}, "terms": {"zernike": {"n_max": 4}},
      "solve": {"for": ["/roughness/psd/rms"], "so_that": {"strehl": ">= 0.8"}},
      "vary": {"over": {"/roughness/psd/rms": [10e-9]}}})");
    if (!with.empty()) study["solve"]["with"] = ordered_json::parse(with);
    study["vary"]["run"] = run;
    folder_.write("study.json", study.dump());
    EXPECT_LE(
        test::run_program(folder_, command + " study.json --json --quiet --pictures none --force -o out"), 1)
        << read_file(folder_.file("stderr.txt"));
    std::vector<std::string> sentences;
    const ordered_json result = ordered_json::parse(read_file(folder_.file("stdout.txt")));
    for (const ordered_json& warning : result["warnings"])
      if (warning["code"] == "contributors-not-used") sentences.push_back(warning["message"]);
    return sentences;
  }
};

TEST_F(UnusedParts, OfTheLightsPathAreSaidByFitAndSweepAndNotBySolve) {
  const std::string air = R"({"atmosphere": {"r0": "15 cm", "wavelength": "500 nm"}})";
  const std::string shake = R"({"jitter": "0.1 urad"})";
  const std::string flat =
      R"({"surfaces": [{"name": "fold", "psd": {"model": "uniform", "rms": 5e-9, "f_min": 5, "f_max": 9}}]})";
  const std::string both = R"({"jitter": "0.1 urad", "atmosphere": {"r0": "15 cm", "wavelength": "500 nm"}})";
  const auto expect_said = [&](const char* command, const std::string& with, const char* parts) {
    const std::vector<std::string> found = said(command, with);
    ASSERT_EQ(found.size(), 1u) << command << with;
    EXPECT_NE(found[0].find(parts), std::string::npos) << found[0];
    EXPECT_NE(found[0].find("solve"), std::string::npos) << found[0];
  };
  expect_said("sweep", air, "(atmosphere)");
  expect_said("sweep", shake, "(jitter)");
  expect_said("sweep", flat, "(surfaces)");
  expect_said("fit", both, "(atmosphere, jitter)");
  for (const char* command : {"fit", "sweep"}) EXPECT_TRUE(said(command, "").empty()) << command;
  EXPECT_TRUE(said("solve", shake).empty());
  EXPECT_TRUE(said("sweep", shake, "solve").empty());
}

}  // namespace
}  // namespace aberfit
