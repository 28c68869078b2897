// Reads the seeds of all fuzz targets, and inputs that once made a reader fail.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "aberfit/study/read_study.h"
#include "fuzz/harness.h"
#include "fuzz/targets.h"

namespace aberfit::test {
namespace {

const std::filesystem::path kCorpus = std::filesystem::path(ABERFIT_SOURCE_DIR) / "tests/fuzz/corpus";

TEST(FuzzReplay, SeedsAreReadOrRefused) {
  for (const FuzzTarget& target : fuzz_targets()) {
    SCOPED_TRACE(target.name);
    const std::vector<std::string> seeds = target.seeds();
    EXPECT_FALSE(seeds.empty());
    for (const std::string& seed : seeds) {
      EXPECT_NO_THROW(target.read(seed)) << seed.substr(0, 200);
      EXPECT_NO_THROW(target.read(seed.substr(0, seed.size() / 2))) << seed.substr(0, 200);
    }
    EXPECT_NO_THROW(target.read(""));
  }
}

// A seed that is refused at its first key is useless.
TEST(FuzzReplay, SeedsOfStudiesAreStudies) {
  const std::vector<FuzzTarget> targets = study_targets();
  targets.front().read(targets.front().seeds().front());  // writes the files that they name
  for (const std::string& seed : targets.front().seeds())
    EXPECT_NO_THROW(parse_study(seed, fuzz_folder().path("study.json"))) << seed;
}

TEST(FuzzReplay, InputsThatOnceDidHarmAreReadOrRefused) {
  std::set<std::string> names;
  int inputs = 0;
  for (const FuzzTarget& target : fuzz_targets()) {
    names.insert(target.name);
    if (!std::filesystem::is_directory(kCorpus / target.name)) continue;
    for (const auto& file : std::filesystem::directory_iterator(kCorpus / target.name)) {
      EXPECT_NO_THROW(target.read(bytes_of(file.path()))) << file.path();
      ++inputs;
    }
  }
  EXPECT_GT(inputs, 0);
  for (const auto& folder : std::filesystem::directory_iterator(kCorpus))
    EXPECT_TRUE(names.contains(folder.path().filename())) << folder.path() << " is of no target";
}

}  // namespace
}  // namespace aberfit::test
