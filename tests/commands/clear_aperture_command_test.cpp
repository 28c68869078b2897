// The clear aperture of measured files through the program. Options and study keys mean the same, text, JSON
// and picture show it, and errors name the cause.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "aberfit/measured/write_map.h"
#include "aberfit/roughness/random_surface.h"
#include "aberfit/study/read_study.h"
#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using namespace test;
using nlohmann::ordered_json;

// A k-correlation surface on a 64 mm disc, whose rim is turned down by a micrometre over its last 4 mm.
HeightMap turned_down() {
  HeightMap map = random_surface(RadialPsd(KCorrelationPsd{20e-9, 0.012, 3}), 65, 65, 1e-3, {.seed = 4});
  for (Eigen::Index r = 0; r < 65; ++r)
    for (Eigen::Index c = 0; c < 65; ++c) {
      const double rho = std::hypot(map.x(c), map.y(r));
      if (rho > 28e-3) map.height(r, c) -= 1e-6 * std::pow((rho - 28e-3) / 4e-3, 2);
      if (rho > 32e-3) map.height(r, c) = std::nan("");
    }
  return map;
}

class ClearApertureOfAFile : public testing::Test {
 protected:
  void SetUp() override { folder.write("map.csv", map_csv(turned_down())); }
  ordered_json psd(const std::string& options) {
    EXPECT_EQ(run_program(folder, "psd map.csv --of surface --outliers keep -o out " + options), 0)
        << read_file(folder.file("stderr.txt"));
    return ordered_json::parse(read_file(folder.file("out/result.json")));
  }
  std::string error_of(const std::string& options) {
    EXPECT_EQ(run_program(folder, "psd map.csv --of surface --pictures none " + options), 2) << options;
    return read_file(folder.file("stderr.txt"));
  }
  const ScratchFolder folder;
};

long inside(const HeightMap& map, double radius) {
  long count = 0;
  for (Eigen::Index r = 0; r < map.rows(); ++r)
    for (Eigen::Index c = 0; c < map.columns(); ++c)
      count += std::isfinite(map.height(r, c)) && std::hypot(map.x(c), map.y(r)) <= radius * (1 + 1e-9);
  return count;
}

TEST_F(ClearApertureOfAFile, TakesTheRimOffAndSaysSo) {
  const ordered_json whole = psd("--pictures none"), clear = psd("--aperture circle:diameter=56mm");
  const auto rms = [](const ordered_json& result) {
    return result["estimate"]["rms_height_m"].get<double>();
  };
  EXPECT_GT(rms(whole), 5 * rms(clear));
  const long left = inside(turned_down(), 28e-3);
  const ordered_json& measured = clear["measurements"][0];
  EXPECT_EQ(measured["valid"], left);
  EXPECT_EQ(measured["clear"]["taken_out"], inside(turned_down(), 32e-3) - left);
  EXPECT_EQ(measured["clear"]["aperture"], "circle of 56 mm about (0 m, 0 m)");
  EXPECT_TRUE(whole["measurements"][0]["clear"].is_null());
  const std::string text = read_file(folder.file("out/summary.txt"));
  EXPECT_NE(text.find("clear aperture:"), std::string::npos) << text;
  EXPECT_NE(text.find("circle of 56 mm about (0 m, 0 m);"), std::string::npos) << text;
  EXPECT_NE(read_file(folder.file("out/plots/data.values")).find("rims = 1"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(folder.file("out/plots/data_rim.dat")));
}

TEST_F(ClearApertureOfAFile, IsTheSameByOptionAndByStudyKey) {
  const ordered_json by_option =
      psd("--pictures none --aperture annulus:outer=56mm,inner=12.5%,center=1mm,-2mm --erode 1");
  folder.write("study.json",
               R"({"aberfit": 1, "mirror": {"focal_length": "1 m"}, "light": {"wavelength": "632.8 nm"},
                   "aperture": {"shape": "circle", "diameter": "63 mm"},
                   "roughness": {"psd": {"model": "measured", "file": "map.csv", "of": "surface", "outliers": "keep",
                     "aperture": {"shape": "annulus", "diameter": "56 mm", "inner_diameter": "12.5 %",
                                  "centre": ["1 mm", "-2 mm"]}, "erode": 1}}})");
  EXPECT_EQ(run_program(folder, "psd study.json --pictures none -o study"), 0)
      << read_file(folder.file("stderr.txt"));
  const ordered_json by_study = ordered_json::parse(read_file(folder.file("study/result.json")));
  EXPECT_EQ(by_option["request"]["aperture"], by_study["request"]["aperture"]);
  EXPECT_EQ(by_option["measurements"][0]["clear"], by_study["measurements"][0]["clear"]);
  EXPECT_EQ(by_option["estimate"], by_study["estimate"]);
  EXPECT_EQ(by_option["request"]["aperture"]["inner_diameter"], "12.5 %");
  // The requested aperture can be read back.
  const MeasuredPsd again = [&] {
    ordered_json block = by_option["request"];
    block.erase("model");
    block["file"] = folder.file("map.csv");
    return read_measured(block, "request", 1);
  }();
  EXPECT_EQ(again.clear.at(0).taken_out, by_option["measurements"][0]["clear"]["taken_out"]);
}

TEST_F(ClearApertureOfAFile, OfAMapThatIsFitted) {
  folder.write("study.json",
               R"({"aberfit": 1, "mirror": {"focal_length": "1 m"}, "light": {"wavelength": "632.8 nm"},
                   "aperture": {"shape": "circle", "diameter": "56 mm"}, "trace": {"rays": 1024},
                   "target": {"map": {"file": "map.csv", "of": "surface", "outliers": "keep",
                     "aperture": {"shape": "circle", "diameter": "75 %", "centre": ["2 mm", "0 mm"]}}},
                   "terms": {"zernike": {"n_max": 4}}})");
  EXPECT_EQ(run_program(folder, "fit study.json -o out"), 0) << read_file(folder.file("stderr.txt"));
  const ordered_json result = ordered_json::parse(read_file(folder.file("out/result.json")));
  const ordered_json& clear = result["map"]["clear"];
  EXPECT_GT(clear["taken_out"], 0);
  // The origin is the middle of the remaining points, which is that of the aperture.
  EXPECT_NEAR(clear["centre_m"][0].get<double>(), 0, 0.6e-3);
  EXPECT_NE(read_file(folder.file("out/summary.txt")).find("clear aperture: circle of 48 mm"),
            std::string::npos);
  EXPECT_NE(read_file(folder.file("out/plots/surface.values")).find("rims = 1"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(folder.file("out/plots/surface_rim.dat")));
}

TEST_F(ClearApertureOfAFile, ErrorsSayWhatIsWrong) {
  folder.write("small.csv", "1 1\n1 1\n");
  const auto says = [&](const std::string& options, const std::string& words) {
    const std::string error = error_of(options);
    EXPECT_NE(error.find(words), std::string::npos) << options << ": " << error;
  };
  says("--aperture hexagon:diameter=5mm", "\"circle\", \"annulus\", \"rectangle\", \"interval\"");
  says("--aperture interval:length=90%", "circle, annulus or rectangle");
  says("--aperture circle:diameter=120%", "at most 100 %");
  says("--aperture circle:diameter=95", "95 m is more than twice the extent of the data, 64 mm");
  says("--aperture circle:diameter=wide", "\"95 %\"");
  says("--aperture circle:radius=5mm", "radius");
  says("--aperture circle:95%", "SHAPE:key=value");
  says("--aperture circle:diameter=1,5mm", "with decimal points");
  says("--aperture circle:diameter=10mm,diameter=5mm", "\"diameter\" is given twice");
  says("--aperture annulus:outer=50mm,inner=9mm,diameter=5mm", "\"diameter\" is given twice");
  says("--aperture circle:diameter=5mm,centre=1mm,2mm,centre=0mm,0mm", "\"centre\" is given twice");
  says("--aperture annulus:outer=30%,inner=30%", "less than the outer diameter");
  says("--aperture circle:diameter=1mm,centre=1m,0m", "no sample is left");
  says("--aperture circle:diameter=1mm,centre=1mm", "two lengths");
  says("--erode 40", "no sample is left");
  says("--mask small.csv", "the mask has 2 x 2 points, the map 65 x 65");
  says("--mask none.csv", "none.csv");
}

}  // namespace
}  // namespace aberfit
