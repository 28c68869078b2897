// Outliers of measured files through the program: what `psd`, `fit` and `check` report about a map, and how
// they are rejected.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "aberfit/measured/write_map.h"
#include "aberfit/roughness/random_surface.h"
#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using namespace test;
using nlohmann::ordered_json;

constexpr int kSpikes = 7;

// A k-correlation surface of 64 mm, with spikes of a micrometre on the diagonal every 8 mm.
std::string spoilt_map() {
  HeightMap map = random_surface(RadialPsd(KCorrelationPsd{20e-9, 0.012, 3}), 64, 64, 1e-3, {.seed = 4});
  for (int i = 1; i <= kSpikes; ++i) map.height(8 * i, 8 * i + 1) += 1e-6;
  return map_csv(map);
}

const ordered_json* warning(const ordered_json& result, const std::string& code) {
  for (const auto& each : result["warnings"])
    if (each["code"] == code) return &each;
  return nullptr;
}

TEST(OutliersOfAFile, AreToldRejectedOrKept) {
  const ScratchFolder folder;
  folder.write("map.csv", spoilt_map());
  const auto run = [&](const std::string& options) {
    EXPECT_EQ(run_program(folder, "psd map.csv --of surface --pictures none -o out " + options), 0)
        << read_file(folder.file("stderr.txt"));
    return ordered_json::parse(read_file(folder.file("out/result.json")));
  };
  const ordered_json told = run(""), rejected = run("--outliers reject"), kept = run("--outliers keep");
  const auto slope = [](const ordered_json& result) { return result["estimate"]["rms_slope"].get<double>(); };
  EXPECT_EQ(slope(told), slope(kept));
  EXPECT_LT(slope(rejected), 0.5 * slope(kept));
  EXPECT_EQ(rejected["measurements"][0]["valid"], 64 * 64 - kSpikes);
  EXPECT_EQ(rejected["request"]["outliers"], "reject");
  EXPECT_FALSE(warning(kept, "outliers") || warning(kept, "outliers-rejected"));
  ASSERT_TRUE(warning(told, "outliers") && warning(rejected, "outliers-rejected"));
  // The sentence has the numbers of both runs.
  const std::string sentence = (*warning(told, "outliers"))["message"];
  EXPECT_NE(sentence.find(fmt::format("{} of 4,096 samples", kSpikes)), std::string::npos) << sentence;
  EXPECT_NE(sentence.find(fmt::format("RMS slope is {:.4g} urad instead of {:.4g} urad",
                                      1e6 * slope(rejected), 1e6 * slope(told))),
            std::string::npos)
      << sentence;
  EXPECT_EQ(run_program(folder, "psd map.csv --outliers away --pictures none"), 2);
}

TEST(OutliersOfAFile, OfAMapThatIsFittedAreToldByFitAndCheck) {
  const ScratchFolder folder;
  folder.write("map.csv", spoilt_map());
  const auto study = [&](const std::string& keys) {
    folder.write("study.json",
                 R"({"aberfit": 1, "mirror": {"focal_length": "1 m"}, "light": {"wavelength": "632.8 nm"},
                     "aperture": {"shape": "circle", "diameter": "63 mm"}, "trace": {"rays": 1024},
                     "target": {"map": {"file": "map.csv", "of": "surface", "origin": "grid")" +
                     keys + R"(}}, "terms": {"zernike": {"n_max": 4}}, "output": {"pictures": "none"}})");
  };
  const auto json = [&](const std::string& command) {
    EXPECT_EQ(run_program(folder, command + " study.json --json"), 0) << read_file(folder.file("stderr.txt"));
    return ordered_json::parse(read_file(folder.file("stdout.txt")));
  };
  study("");
  const ordered_json told = json("fit");
  EXPECT_TRUE(warning(told, "outliers"));
  EXPECT_TRUE(warning(json("check"), "outliers"));
  study(R"(, "outliers": "reject")");
  const ordered_json rejected = json("fit");
  EXPECT_TRUE(warning(rejected, "outliers-rejected"));
  EXPECT_LT(rejected["map"]["rms_residual_m"], told["map"]["rms_residual_m"]);
  const int left = json("check")["map"]["valid"];
  study("");
  EXPECT_EQ(left + kSpikes - 2, json("check")["map"]["valid"]);  // two are outside the mirror
}

// A file gives heights in nanometres but says metres.
TEST(OutliersOfAFile, ValuesInAWrongUnitAreUnusual) {
  const ScratchFolder folder;
  std::string text = "x [mm],height [mm]\n";
  const Profile profile = random_profile(RadialPsd(KCorrelationPsd{20e-9, 0.012, 3}), 500, 1e-3, {.seed = 4});
  for (Eigen::Index i = 0; i < profile.size(); ++i) text += fmt::format("{},{}\n", i, 1e9 * profile.value[i]);
  folder.write("line.csv", text);
  EXPECT_EQ(run_program(folder, "psd line.csv --pictures none -o out"), 0);
  const ordered_json result = ordered_json::parse(read_file(folder.file("out/result.json")));
  ASSERT_TRUE(warning(result, "unusual"));
  EXPECT_NE(read_file(folder.file("stdout.txt")).find("unusual"), std::string::npos);
}

}  // namespace
}  // namespace aberfit
