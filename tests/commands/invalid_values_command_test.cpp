// Padding values in maps, through the program: the messages of `psd`, `check` and `fit`, and the effect of
// `invalid`.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "aberfit/core/text.h"
#include "aberfit/roughness/random_surface.h"
#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using namespace test;
using nlohmann::ordered_json;

constexpr int kSide = 64;

// A k-correlation surface with power on a disc of 58 mm, one point per millimetre. The words stand outside
// the disc, in turn.
std::string padded_map(const std::vector<std::string>& outside) {
  const HeightMap map =
      random_surface(RadialPsd(KCorrelationPsd{5e-9, 0.012, 3}), kSide, kSide, 1e-3, {.seed = 4});
  std::string text = "# of: surface\n# pitch = 1 mm\n# unit: nm\n";
  std::size_t turn = 0;
  for (Eigen::Index r = kSide - 1; r >= 0; --r)
    for (Eigen::Index c = 0; c < kSide; ++c) {
      const double rho = std::hypot(map.x(c), map.y(r)) / 0.029;
      text += rho < 1 ? fmt::format("{:.3f}", 1e9 * map.height(r, c) + 150 * rho * rho + 20)
                      : outside[turn++ % outside.size()];
      text += c + 1 < kSide ? ' ' : '\n';
    }
  return text;
}

const ordered_json* warning(const ordered_json& result, const std::string& code) {
  for (const auto& each : result["warnings"])
    if (each["code"] == code) return &each;
  return nullptr;
}

ordered_json psd(const ScratchFolder& folder, const std::string& words) {
  EXPECT_NE(run_program(folder, "psd " + words + " --pictures none -o out"), 2)
      << read_file(folder.file("stderr.txt"));
  return ordered_json::parse(read_file(folder.file("out/result.json")));
}

// The printed text, its lines joined.
std::string printed(const ScratchFolder& folder) {
  std::string text;
  for (const std::string_view word : words(read_file(folder.file("stdout.txt"))))
    text += std::string(word) + ' ';
  return text;
}

TEST(InvalidValues, MakeOfAPaddedMapTheOneWithHoles) {
  const ScratchFolder folder;
  folder.write("holes.txt", padded_map({"nan"}));
  const ordered_json truth = psd(folder, "holes.txt --aperture circle:diameter=95%");
  EXPECT_FALSE(warning(truth, "padding"));
  struct Padded {
    std::vector<std::string> outside;
    std::string options;
  };
  for (const Padded& padded :
       {Padded{{"0"}, "--invalid 0"}, Padded{{"-9999.0"}, "--invalid -9999"},
        Padded{{"0", "-9999"}, "--invalid 0,-9999"}, Padded{{"0", "-9999"}, "--invalid 0 --invalid -9999"},
        Padded{{"3.4028235e+12"}, "--invalid 3.4028235e12"}}) {
    folder.write("map.txt", padded_map(padded.outside));
    const ordered_json read = psd(folder, "map.txt --aperture circle:diameter=95% " + padded.options);
    EXPECT_EQ(read["estimate"].dump(), truth["estimate"].dump()) << padded.options;
    EXPECT_EQ(read["measurements"][0]["valid"], truth["measurements"][0]["valid"]);
    // A few percent of the circle around the valid points.
    EXPECT_EQ(read["measurements"][0]["clear"]["aperture"], truth["measurements"][0]["clear"]["aperture"]);
    EXPECT_GT(read["measurements"][0]["clear"]["said_invalid"], 1000);
    EXPECT_FALSE(warning(read, "padding"));
    const std::string text = printed(folder);
    EXPECT_NE(text.find("with a value of `invalid` became holes"), std::string::npos) << text;
  }
}

TEST(InvalidValues, ThatAreNotSaidAreToldWithTheirEffect) {
  const ScratchFolder folder;
  folder.write("holes.txt", padded_map({"nan"}));
  folder.write("map.txt", padded_map({"0"}));
  const ordered_json truth = psd(folder, "holes.txt"), told = psd(folder, "map.txt");
  const ordered_json* padding = warning(told, "padding");
  ASSERT_TRUE(padding);
  const std::string sentence = (*padding)["message"];
  const auto slope = [](const ordered_json& result) { return result["estimate"]["rms_slope"].get<double>(); };
  const long outside = kSide * kSide - truth["measurements"][0]["valid"].get<long>();
  EXPECT_NE(sentence.find(fmt::format("{},{:03} of 4,096 points", outside / 1000, outside % 1000)),
            std::string::npos)
      << sentence;
  EXPECT_NE(sentence.find("all of them outside the convex hull of the others, in 1 block"), std::string::npos)
      << sentence;
  EXPECT_NE(sentence.find(fmt::format("RMS slope is {:.4g} urad instead of {:.4g} urad", 1e6 * slope(truth),
                                      1e6 * slope(told))),
            std::string::npos)
      << sentence;
  EXPECT_NE(sentence.find("--invalid 0"), std::string::npos) << sentence;
}

TEST(InvalidValues, ThatNoSampleHasAreToldAsSuch) {
  const ScratchFolder folder;
  folder.write("map.txt", padded_map({"nan"}));
  EXPECT_EQ(psd(folder, "map.txt --invalid -32768")["measurements"][0]["clear"]["said_invalid"], 0);
  EXPECT_NE(printed(folder).find("no sample has a value of `invalid`"), std::string::npos);
  EXPECT_EQ(run_program(folder, "psd map.txt --invalid none --pictures none"), 2);
}

TEST(InvalidValues, OfAMapThatIsFittedAreAKeyOfTheStudy) {
  const ScratchFolder folder;
  folder.write("map.txt", padded_map({"0"}));
  folder.write("holes.txt", padded_map({"nan"}));
  const auto study = [&](const std::string& file, const std::string& keys) {
    folder.write("study.json",
                 R"({"aberfit": 1, "mirror": {"focal_length": "1 m"}, "light": {"wavelength": "632.8 nm"},
                     "aperture": {"shape": "circle", "diameter": "62 mm"}, "trace": {"rays": 1024},
                     "target": {"map": {"file": ")" +
                     file + R"(", "origin": "circle")" + keys +
                     R"(}}, "terms": {"zernike": {"n_max": 4}}, "output": {"pictures": "none"}})");
    EXPECT_EQ(run_program(folder, "fit study.json -o out"), 0) << read_file(folder.file("stderr.txt"));
    return ordered_json::parse(read_file(folder.file("out/result.json")));
  };
  const ordered_json truth = study("holes.txt", ""), read = study("map.txt", R"(, "invalid": [0])"),
                     told = study("map.txt", "");
  EXPECT_EQ(read["coefficients"].dump(), truth["coefficients"].dump());
  EXPECT_GT(read["map"]["clear"]["said_invalid"], 1000);
  EXPECT_FALSE(warning(read, "padding"));
  EXPECT_EQ(read["map"]["pitch_x_m"], 1e-3);
  EXPECT_GT(read["map"]["heights"]["measured"]["rms_slope_y"], 0);
  EXPECT_NE(read_file(folder.file("out/summary.txt")).find("per axis ("), std::string::npos);
  // Inside the circle around all points there is a ring of padding.
  EXPECT_NE(told["coefficients"].dump(), truth["coefficients"].dump());
}

}  // namespace
}  // namespace aberfit
