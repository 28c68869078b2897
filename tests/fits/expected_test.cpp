// Every reference study must give the results of its expected.json. smooth_waves_test.cpp does it for
// fits/smooth-waves.
#include "fits/expected.h"

#include "aberfit/commands/run.h"
#include "aberfit/report/documents.h"
#include "aberfit/study/read_study.h"

using namespace aberfit;

class ReferenceStudy : public testing::TestWithParam<const char*> {};

TEST_P(ReferenceStudy, GivesWhatItsExpectedFileSays) {
  const std::string folder = std::string(ABERFIT_SOURCE_DIR "/fits/") + GetParam();
  const Study study = read_study(folder + "/study.json");
  RunOptions options;
  options.threads = 2;
  const ResultDocument result = run_fit(study, options);
  test::expect_what_the_file_says(to_json(result, resolved(study, result)), folder);
}

INSTANTIATE_TEST_SUITE_P(Fits, ReferenceStudy,
                         testing::Values("paper-mirror", "paper-physical", "paper-harvey-shack",
                                         "paper-published-values", "spherical", "measured-zygo",
                                         "large-annulus", "infrared-6.5m", "euv"),
                         [](const auto& study) {
                           std::string name = study.param;
                           std::erase_if(name, [](char c) { return c == '-' || c == '.'; });
                           return name;
                         });
