// Twenty seeds of five scenes: whether a verdict is `equivalent` is not a matter of the draw.
#include <gtest/gtest.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "aberfit/commands/run.h"
#include "aberfit/study/read_study.h"
#include "reference_scenes.h"

namespace aberfit {
namespace {

using nlohmann::json;

struct Scene {
  const char* name;
  json study;
};

std::vector<Scene> scenes() {
  json smooth = study_of(2.8, circle(0.4), uniform(25e-9, 19.96));
  smooth["terms"] = {{"zernike", {{"n_max", 28}}}};
  return {{"README", readme_study()},
          {"smooth", smooth},
          {"annulus f/4", annulus_study()},
          {"f/2", study_of(0.6, circle(0.3), k_correlation(40e-9, 2.8, 40))},
          {"g = 5", study_of(3, circle(0.4), uniform(252e-9, 12))}};
}

class SeedSweep : public testing::TestWithParam<int> {};

TEST_P(SeedSweep, AllButOneOfTwentyAreEquivalent) {
  const Scene scene = scenes()[std::size_t(GetParam())];
  int equivalent = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    json study = scene.study;
    study["fit"]["seed"] = seed;
    const ResultDocument result = run_fit(parse_study(study.dump(), "seeds.json"), {});
    equivalent += result.verdict == Verdict::kEquivalent;
    std::printf("%s, seed %d: %s, %d terms\n", scene.name, seed, to_string(result.verdict).c_str(),
                int(result.terms.size()));
    std::fflush(stdout);
  }
  EXPECT_GE(equivalent, 19) << scene.name;
}
INSTANTIATE_TEST_SUITE_P(Of, SeedSweep, testing::Range(0, 5));

}  // namespace
}  // namespace aberfit
