// `aberfit solve` with a measured focus, from the outside: a curve and an image, the printed text, and
// refusals.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "aberfit/specify/contributors.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;
using test::read_file;
using test::run_program;
using test::ScratchFolder;

constexpr double kFocalLength = 2.4, kArcsec = 3.14159265358979323846 / 648000, kWavelength = 550e-9;
const KCorrelationPsd kTruth{22e-9, 0.06, 3, 1, 2000};

std::string focus_study(const std::string& focus) {
  return R"({ "aberfit": 1, "title": "primary", "mirror": { "focal_length": "2.4 m" },
  "aperture": { "shape": "annulus", "diameter": "1.2 m", "inner_diameter": "0.36 m" },
  "light": { "wavelength": "550 nm" },
  "roughness": { "psd": { "model": "k-correlation", "rms": "40 nm", "B": "10 cm", "exponent": 3, "f_min": "1 /m",
                          "f_max": "2000 /m" } },
  "solve": { "for": ["/roughness/psd/rms", "/roughness/psd/B"], "focus": )" +
         focus + "}}";
}

GeneralisedHarveyShack true_light() {
  return {RadialPsd(kTruth), Mirror{kFocalLength}, AnnulusAperture{1.2, 0.36}, kWavelength};
}

class SolveFocusCommand : public ::testing::Test {
 protected:
  int run(const std::string& arguments) const { return run_program(folder_, arguments); }
  std::string out() const { return read_file(folder_.file("stdout.txt")); }
  std::string err() const { return read_file(folder_.file("stderr.txt")); }

  // Writes a curve with diameters on the sky and energy in percent, from zero on.
  void write_curve(double noise) {
    const MeanSpot spot = true_light().at_plane(0);
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal(0, noise);
    std::string text = "# a star test\ndiameter [arcsec], ee [%], noise [%]\n0, 0, 0\n";
    for (int k = 0; k < 30; ++k) {
      const double diameter = 0.15 * std::pow(60, k / 29.0);
      const double share = spot.encircled_energy(0.5 * diameter * kArcsec * kFocalLength) + normal(random);
      text += fmt::format("{:.6g}, {:.5f}, {:.3f}\n", diameter, 100 * share, 100 * noise);
    }
    folder_.write("ee.csv", text);
  }
  // Writes an image with pixels of 2 um, 2e6 photoelectrons on a background of 25 per pixel with noise of 10;
  // the axis lies between pixels.
  void write_image() {
    constexpr int kSide = 81;
    constexpr double kPixel = 2e-6;
    const MeanSpot spot = true_light().at_plane(0);
    std::vector<double> irradiance;  // at steps of a hundredth of a pixel
    for (int k = 0; k < 100 * 60; ++k) {
      const double radius = std::max(k * kPixel / 100, 1e-9);
      irradiance.push_back(spot.encircled_energy_slope(radius) / (2 * 3.14159265358979323846 * radius));
    }
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal(0, 1);
    std::string text;
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        double sum = 0;
        constexpr int kParts = 32;
        for (int i = 0; i < kParts; ++i)
          for (int j = 0; j < kParts; ++j) {
            const double x = column - 40.3 + (i + 0.5) / kParts - 0.5,
                         y = row - 39.8 + (j + 0.5) / kParts - 0.5;
            const double at = 100 * std::hypot(x, y), floor = std::floor(at);
            const auto k = std::size_t(floor);
            sum += irradiance[k] + (at - floor) * (irradiance[k + 1] - irradiance[k]);
          }
        const double photons = 2e6 * sum * kPixel * kPixel / (kParts * kParts) + 25;
        text +=
            fmt::format("{}{:.6g}", column ? " " : "", photons + std::sqrt(photons + 100) * normal(random));
      }
      text += "\n";
    }
    folder_.write("star.txt", text);
  }
  void expect_truth(const ordered_json& json) const {
    for (std::size_t k : {0, 1}) {
      const ordered_json& number = json["numbers"][k];
      const double truth = k == 0 ? kTruth.rms : kTruth.correlation;
      EXPECT_TRUE(bool(number["identified"]));
      EXPECT_LT(std::abs(std::log(double(number["value"]) / truth)), 3.5 * double(number["relative_std"]))
          << number;
      EXPECT_LT(double(number["relative_std"]), 0.2) << number;
    }
  }
  ScratchFolder folder_;
};

TEST_F(SolveFocusCommand, FindsTheRoughnessOfACurve) {
  write_curve(0.003);
  folder_.write("study.json", focus_study(R"({"file": "ee.csv", "of": "mean"})"));
  EXPECT_EQ(run("solve study.json --json --quiet -o result"), 0) << err();
  const ordered_json json = ordered_json::parse(out());
  EXPECT_EQ(json["kind"], "psd-of-focus");
  EXPECT_EQ(json["status"], "fitted");
  expect_truth(json);
  EXPECT_GT(double(json["goodness"]), 1e-3);
  EXPECT_EQ(json, ordered_json::parse(read_file(folder_.file("result/result.json"))));
  const std::string summary = read_file(folder_.file("result/summary.txt"));
  EXPECT_EQ(summary.find("FITTED: rms = 2"), 0u) << summary;
  std::istringstream lines(summary);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  EXPECT_EQ(read_file(folder_.file("result/focus.csv")).find("radius_m,measured_share"), 0u);
  EXPECT_GT(read_file(folder_.file("result/plots/focus.svg")).size(), 1000u);
  // The resolved study asks the same question.
  folder_.write("resolved.json", json["study"].dump());
  EXPECT_EQ(run("solve resolved.json --json --quiet --pictures none -o again"), 0) << err();
  EXPECT_EQ(ordered_json::parse(out())["numbers"], json["numbers"]);
}

TEST_F(SolveFocusCommand, FindsTheRoughnessOfAnImageWithPixelsAndBackground) {
  write_image();
  folder_.write(
      "study.json",
      focus_study(R"({"file": "star.txt", "pixel": "2 um", "of": "mean", "noise": 10, "gain": 1})"));
  EXPECT_EQ(run("solve study.json --json --quiet -o result"), 0) << out() << err();
  const ordered_json json = ordered_json::parse(out());
  expect_truth(json);
  EXPECT_NEAR(double(json["total"]), 2e6, 2e4);
  EXPECT_NEAR(double(json["background"]), 25, 2);
  EXPECT_NEAR(double(json["centre_pixels"][0]), 40.3, 0.05);
  // Rows of the file are counted from the top.
  EXPECT_NEAR(double(json["centre_pixels"][1]), 80 - 39.8, 0.05);
  EXPECT_EQ(read_file(folder_.file("result/focus.csv")).find("mean_radius_m,measured_per_pixel"), 0u);
}

// Air moves during an exposure, so it blurs and gives no speckle as a mirror does.
TEST_F(SolveFocusCommand, AirIsNotOneMirrorsOwn) {
  const SumPsd whole{{kTruth, in_pupil(Atmosphere{0.5, kWavelength})}};
  const MeanSpot spot =
      GeneralisedHarveyShack(RadialPsd(whole), Mirror{kFocalLength}, AnnulusAperture{1.2, 0.36}, kWavelength)
          .at_plane(0);
  std::string text = "radius_um, share\n";
  for (int k = 0; k < 20; ++k) {
    const double radius = 1e-6 * std::pow(60, k / 19.0);
    text += fmt::format("{:.6g}, {:.6f}\n", 1e6 * radius, spot.encircled_energy(radius));
  }
  folder_.write("ee.csv", text);
  const auto fitted = [&](const std::string& air) {
    ordered_json study = ordered_json::parse(focus_study(R"({"file": "ee.csv", "noise": 1e-3})"));
    study["solve"]["for"] = {"/roughness/psd/rms"};
    study["roughness"]["psd"]["B"] = kTruth.correlation;
    study["solve"]["with"] = ordered_json::parse(air);
    folder_.write("study.json", study.dump());
    run("solve study.json --json --quiet --pictures none -o result");
    return ordered_json::parse(out());
  };
  const ordered_json json = fitted(R"({"atmosphere": {"r0": "50 cm", "wavelength": "550 nm"}})");
  EXPECT_EQ(json["status"], "fitted") << json["message"];
  EXPECT_NEAR(double(json["numbers"][0]["value"]) / kTruth.rms, 1, 0.02);
  // Only the light of the mirror varies about the mean; a variation of the air would be three times as large.
  for (const double spread : json["light"]["spread"]) EXPECT_LT(spread, 0.05);
}

// The rim of the image is empty, so the answer is the same in any unit.
TEST_F(SolveFocusCommand, TheUnitOfAnImageDoesNotCount) {
  write_image();
  std::vector<double> counts;
  std::istringstream image(read_file(folder_.file("star.txt")));
  for (double value; image >> value;) counts.push_back(std::max(0.0, std::floor(value / 50)));
  std::vector<double> heights;
  for (const double unit : {1.0, 1e-6, 1e6}) {
    std::string text;
    for (std::size_t k = 0; k < counts.size(); ++k)
      text += fmt::format("{:.9g}{}", unit * counts[k], (k + 1) % 81 == 0 ? "\n" : " ");
    folder_.write("star.txt", text);
    folder_.write("study.json", focus_study(R"({"file": "star.txt", "pixel": "2 um"})"));
    run("solve study.json --json --quiet --pictures none -o result --set "
        "'/solve/for=[\"/roughness/psd/rms\"]'");
    heights.push_back(double(ordered_json::parse(out())["numbers"][0]["best"]));
  }
  EXPECT_NEAR(heights[1] / heights[0], 1, 1e-4);
  EXPECT_NEAR(heights[2] / heights[0], 1, 1e-4);
}

TEST_F(SolveFocusCommand, SaysWhatIsWrongWithTheData) {
  struct Case {
    const char *curve, *focus, *says;
  };
  for (const Case& wrong : {
           Case{"radius,share\n1,0.5\n2,0.6\n", R"({"file": "ee.csv"})", "no unit"},
           Case{"radius_um,share\n1,0.5\n1,0.6\n", R"({"file": "ee.csv"})", "increasing radii"},
           Case{"radius_um,share\n0,0.1\n1,0.6\n", R"({"file": "ee.csv"})", "radii above zero"},
           Case{"radius_um,share\n1,50\n2,60\n", R"({"file": "ee.csv"})", "in %"},
           Case{"radius_um,height\n1,0.5\n2,0.6\n", R"({"file": "ee.csv"})", "height"},
           Case{"radius_um,share\n1,0.5\n2,0.6\n", R"({"file": "ee.csv"})", "more data than unknowns"},
           Case{"1 2 3 4\n2 3 4 5\n3 4 9 8\n2 3 4 4\n", R"({"file": "ee.csv"})", "pixel"},
           Case{"radius_um,share\n1,0.5\n2,0.6\n", R"({"file": "other.csv"})", "not a readable file"},
           Case{"radius_um,share\n1,0.5\n2,0.6\n", R"({"file": "ee.csv", "pixel": "2 kg"})",
                "/solve/focus/pixel"},
       }) {
    folder_.write("ee.csv", wrong.curve);
    folder_.write("study.json", focus_study(wrong.focus));
    EXPECT_EQ(run("solve study.json --quiet -o result"), 2) << wrong.says;
    EXPECT_NE(err().find(wrong.says), std::string::npos) << wrong.says << " not in " << err();
  }
  folder_.write("study.json", focus_study(R"({"file": "ee.csv"}, "so_that": {"strehl": ">= 0.8"})"));
  EXPECT_EQ(run("solve study.json --quiet -o result"), 2);
  EXPECT_NE(err().find("either `so_that`"), std::string::npos) << err();
}

}  // namespace
}  // namespace aberfit
