// `--set` and `-` give the same as the changed file, for every command that takes a study.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "study/run_program.h"
#include "study/scratch_folder.h"
#include "study/study_texts.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;
using test::read_file;
using test::run_program;
using test::ScratchFolder;

class StudyChangesCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_.write("study.json", kStudy);
    std::string rough = kStudy;
    rough.replace(rough.find("200 nm"), 6, "150 nm");
    folder_.write("rough.json", rough);
  }
  int run(const std::string& arguments) const { return run_program(folder_, arguments); }
  ordered_json json() const { return ordered_json::parse(out()); }
  std::string out() const { return read_file(folder_.file("stdout.txt")); }
  std::string err() const { return read_file(folder_.file("stderr.txt")); }

  static inline const std::string kStudy = R"({ "aberfit": 1, "mirror": { "focal_length": "2.8 m" },
    "aperture": { "shape": "circle", "diameter": "0.4 m" }, "light": { "wavelength": "632.8 nm" },
    "roughness": { "psd": { "model": "uniform", "rms": "200 nm", "f_min": "2.5 /m", "f_max": "6 /m" } },
    "terms": { "zernike": { "n_max": 8 } }, "trace": { "rays": 1024 }, "verify": { "draws": 4 },
    "target": { "theory": "geometric", "statistics": { "ee90": {} } } })";
  ScratchFolder folder_;
};

TEST_F(StudyChangesCommand, EveryCommandTakesThem) {
  for (const char* command : {"check", "trace", "verify --pictures none -o v", "fit --pictures none -o f",
                              "chart --seconds 0.1 --pictures none -o c"}) {
    SCOPED_TRACE(command);
    // The option stands before the study. It must take one value, and not the study, too.
    EXPECT_LE(run(std::string(command) + " --json --quiet --set '/roughness/psd/rms=150 nm' --set /title=x "
                                         "study.json"),
              1)
        << err();
    EXPECT_EQ(json()["study"]["roughness"]["psd"]["rms"], 150e-9);
    EXPECT_EQ(json()["study"]["title"], "x");
  }
  EXPECT_EQ(run("trace rough.json --json"), 0);
  const ordered_json changed_file = json()["statistics"];
  EXPECT_EQ(run("trace study.json --json --set '/roughness/psd/rms=150 nm'"), 0);
  EXPECT_EQ(json()["statistics"], changed_file);
  EXPECT_EQ(run("trace study.json --json"), 0);
  EXPECT_NE(json()["statistics"], changed_file);
}

TEST_F(StudyChangesCommand, ADashIsStandardInput) {
  EXPECT_EQ(run("trace study.json --json --set /title=x"), 0);
  ordered_json by_name = json();
  by_name["provenance"].erase("inputs");  // standard input is no file
  EXPECT_EQ(run("trace - --json --set /title=x < study.json"), 0) << err();
  ordered_json by_input = json();
  by_input["provenance"].erase("inputs");
  EXPECT_EQ(by_input, by_name);
  EXPECT_LE(run("verify - --pictures none < study.json"), 1) << err();
  EXPECT_NE(err().find("results in out/study/verify"), std::string::npos) << err();
  EXPECT_TRUE(std::filesystem::exists(folder_.file("out/study/verify/result.json")));
  EXPECT_EQ(run("psd - < study.json"), 2);
  EXPECT_NE(err().find("standard input: /roughness/psd: found a roughness without a measurement"),
            std::string::npos)
      << err();
  EXPECT_EQ(run("trace - < /dev/null"), 2);
  EXPECT_NE(err().find("standard input: found an empty file"), std::string::npos) << err();
}

TEST_F(StudyChangesCommand, AMistakeIsTheOptions) {
  EXPECT_EQ(run("check study.json --set '/roughness/psd/rms=150 parsec'"), 2);
  EXPECT_NE(err().find("study.json with --set \"/roughness/psd/rms=150 parsec\": /roughness/psd/rms"),
            std::string::npos)
      << err();
  EXPECT_EQ(run("check study.json --set rms"), 2);
  EXPECT_NE(err().find("--set \"rms\""), std::string::npos) << err();
  folder_.write("profile.txt", "0 0\n1 1\n2 0\n3 1\n4 0\n");
  EXPECT_EQ(run("psd profile.txt --set /title=x"), 2);
  EXPECT_NE(err().find("--set \"/title=x\""), std::string::npos) << err();
}

}  // namespace
}  // namespace aberfit
