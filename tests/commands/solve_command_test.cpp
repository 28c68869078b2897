// `aberfit solve` from the outside: exit codes, files, printed text.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;
using test::read_file;
using test::run_program;
using test::ScratchFolder;

const char* const kStudy = R"({ "aberfit": 1, "title": "primary", "mirror": { "focal_length": "100 m" },
  "aperture": { "shape": "circle", "diameter": "0.2 m" }, "light": { "wavelength": "500 nm" },
  "roughness": { "psd": { "model": "uniform", "rms": "30 nm", "f_min": "20 /m", "f_max": "60 /m" } },
  "target": { "theory": "geometric" },
  "solve": { "for": ["/roughness/psd/rms"], "so_that": { "ee80_diameter": "<= 6 arcsec" } } })";

class SolveCommand : public ::testing::Test {
 protected:
  void SetUp() override { folder_.write("study.json", kStudy); }
  int run(const std::string& arguments) const { return run_program(folder_, arguments); }
  std::string out() const { return read_file(folder_.file("stdout.txt")); }
  std::string err() const { return read_file(folder_.file("stderr.txt")); }
  ScratchFolder folder_;
};

TEST_F(SolveCommand, WritesWhatItPrints) {
  EXPECT_EQ(run("solve study.json --json --quiet -o result"), 0) << err();
  ordered_json printed = ordered_json::parse(out());
  EXPECT_EQ(printed["kind"], "solve");
  EXPECT_EQ(printed["status"], "solved");
  EXPECT_EQ(printed["contour"], nullptr);
  EXPECT_EQ(printed["solutions"][0]["holds"], "below");
  EXPECT_NEAR(double(printed["plate_scale_rad_per_m"]), 0.01, 1e-15);
  EXPECT_EQ(printed, ordered_json::parse(read_file(folder_.file("result/result.json"))));
  // The resolved study is a study with the same question.
  folder_.write("resolved.json", printed["study"].dump());
  EXPECT_EQ(run("solve resolved.json --json --quiet -o again"), 0) << err();
  EXPECT_EQ(ordered_json::parse(out())["solutions"], printed["solutions"]);
  const std::string summary = read_file(folder_.file("result/summary.txt"));
  EXPECT_EQ(summary.find("SOLVED: rms <= 20."), 0u) << summary;
  EXPECT_NE(summary.find("2.0626 arcsec/mm"), std::string::npos) << summary;
  std::istringstream lines(summary);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  EXPECT_FALSE(std::filesystem::exists(folder_.file("result/contour.csv")));
}

// S = A f^-3 from f = 0 on has no height variance, but a focus. Half of the energy is within sqrt3 g, g = 32
// pi^3 A/lambda, and the aperture adds 2 lambda/(pi^2 D). 1e6 /m is no end at which rays had a slope.
TEST_F(SolveCommand, TakesARoughnessWithoutALowEnd) {
  const std::string law =
      R"(solve study.json --json --quiet --set /target/theory=ghs --set '/roughness/psd={"model": )"
      R"("power-law", "amplitude": "1e-14 m^4", "exponent": 3, "f_min": 0, "f_max": "1e6 /m"}' )"
      R"(--set '/solve={"for": ["/roughness/psd/amplitude"], "so_that": )";
  EXPECT_EQ(run(law + R"({"ee50_diameter": "<= 8 arcsec"}}')"), 0) << err();
  const ordered_json printed = ordered_json::parse(out());
  constexpr double kPi = 3.141592653589793, kWave = 500e-9, kDiameter = 0.2, kRadius = 4 / 206264.80624709636;
  const double g = kRadius / std::sqrt(3.0) - 2 * kWave / (kPi * kPi * kDiameter);
  EXPECT_NEAR(double(printed["solutions"][0]["at"]["/roughness/psd/amplitude"]) /
                  (g * kWave / (32 * std::pow(kPi, 3))),
              1, 2e-3)
      << printed["solutions"];
  EXPECT_EQ(
      run("check study.json --set '/roughness/psd={\"model\": \"power-law\", \"amplitude\": \"1e-14 m^4\", "
          "\"exponent\": 3, \"f_min\": 0, \"f_max\": \"1e6 /m\"}' --set /solve=null"),
      2);
}

TEST_F(SolveCommand, ReturnsOneWhereThereIsNoSolutionOrNoBound) {
  EXPECT_EQ(run("solve study.json --set '/solve/so_that={\"rms_height\": \"<= 1 m\"}'"), 1) << err();
  EXPECT_EQ(out().find("NO BOUND"), 0u) << out();
  EXPECT_NE(out().find("Every value from"), std::string::npos) << out();
  EXPECT_EQ(
      run("solve study.json --set /target/theory=ghs --set '/solve/so_that/ee80_diameter=<= 0.1 arcsec'"), 1);
  EXPECT_EQ(out().find("NO SOLUTION"), 0u) << out();
  EXPECT_NE(out().find("Airy"), std::string::npos) << out();
  EXPECT_EQ(run("solve study.json --set '/solve/for=[\"/mirror/focal_length\"]'"), 2);
  EXPECT_NE(err().find("/solve/for/0"), std::string::npos) << err();
  folder_.write("plain.json",
                R"({ "aberfit": 1, "mirror": { "focal_length": "1 m" }, "aperture": { "shape": "circle",
    "diameter": "0.2 m" }, "light": { "wavelength": "500 nm" }, "target": { "statistics": { "ee50": { "value": "9 um" } } },
    "terms": { "zernike": { "n_max": 4 } }, "fit": { "prior": "zero-mean" } })");
  EXPECT_EQ(run("solve plain.json"), 2);
  EXPECT_NE(err().find("/solve"), std::string::npos) << err();
}

// The limiting budget is met exactly: the budgeted radius, 1.5 arcsec at f = 2 m, holds 80 % of the energy.
TEST_F(SolveCommand, DrawsTheLightOfTheSolutionThroughItsBudget) {
  EXPECT_EQ(run("solve study.json -o drawn --set \"/mirror/focal_length=2 m\" --set /target/theory=ghs "
                "--set \"/roughness/psd/f_max=200 /m\" --set \"/solve/so_that/ee80_diameter=<= 3 arcsec\""),
            0)
      << err();
  const double radius = 2.0 * 1.5 / 206264.806;
  std::istringstream light(read_file(folder_.file("drawn/plots/budget_light.dat")));
  double before[4] = {}, at[4] = {};
  for (std::string line; at[0] < radius && std::getline(light, line);)
    if (line[0] != '#') {
      std::copy(std::begin(at), std::end(at), before);
      std::istringstream(line) >> at[0] >> at[1] >> at[2] >> at[3];
    }
  EXPECT_LE(before[3], 0.8);
  EXPECT_GE(at[3], 0.8);
  EXPECT_LT(at[3] - before[3], 0.02);
  EXPECT_GT(at[1], at[3]);  // a mirror without roughness keeps more
  const ordered_json result = ordered_json::parse(read_file(folder_.file("drawn/result.json")));
  const double sensitivity =
      result["solutions"][0]["budgets"]["ee80_diameter_rad"]["sensitivity"]["/roughness/psd/rms"];
  std::istringstream bars(read_file(folder_.file("drawn/plots/sensitivities.dat")));
  std::string line;
  double place = 0, bar = 0;
  while (std::getline(bars, line) && line[0] == '#') {
  }
  std::istringstream(line) >> place >> bar;
  EXPECT_EQ(place, 1);
  EXPECT_NEAR(bar / sensitivity, 1, 1e-8);
}

TEST_F(SolveCommand, OfTwoNumbersWritesTheContour) {
  EXPECT_EQ(run("solve study.json -o two --set /solve/for/1=/roughness/psd/f_max"), 0) << err();
  std::istringstream table(read_file(folder_.file("two/contour.csv")));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line, "rms_m,f_max_per_m,ee80_diameter_rad,ee80_diameter_margin,binding");
  std::size_t rows = 0;
  for (; std::getline(table, line); ++rows) EXPECT_TRUE(line.ends_with(",ee80_diameter")) << line;
  const ordered_json result = ordered_json::parse(read_file(folder_.file("two/result.json")));
  EXPECT_EQ(rows, result["contour"]["points"].size());
  EXPECT_GE(rows, 10u);
  for (const char* file : {"contour.gp", "contour.dat"})
    EXPECT_TRUE(std::filesystem::exists(folder_.file(std::string("two/plots/") + file))) << file;
  // Each axis has at least two numbers, however short it is.
  const std::string script = read_file(folder_.file("two/plots/contour.values"));
  for (const char* tics : {"set xtics (", "set ytics ("}) {
    const std::size_t from = script.find(tics);
    ASSERT_NE(from, std::string::npos);
    EXPECT_NE(script.substr(from, script.find(')', from) - from).find(", "), std::string::npos) << script;
  }
}

TEST_F(SolveCommand, SaysWhoUsesTheBudgetOfAPath) {
  ordered_json study = ordered_json::parse(kStudy);
  study.erase("target");
  study["solve"]["with"] = {
      {"surfaces",
       {{{"name", "secondary"},
         {"psd", {{"model", "uniform"}, {"rms", "10 nm"}, {"f_min", "20 /m"}, {"f_max", "100 /m"}}},
         {"footprint", 0.25},
         {"incidence", "30 deg"}}}},
      {"jitter", "0.2 arcsec"}};
  folder_.write("path.json", study.dump());
  EXPECT_EQ(run("solve path.json --json --quiet -o result"), 0) << err();
  const ordered_json printed = ordered_json::parse(out());
  ASSERT_EQ(printed["uses"].size(), 3u);
  EXPECT_EQ(printed["uses"][1]["name"], "secondary");
  EXPECT_GT(double(printed["uses"][0]["alone"]["ee80_diameter_rad"]), 0);
  folder_.write("resolved.json", printed["study"].dump());
  EXPECT_EQ(run("solve resolved.json --json --quiet -o again"), 0) << err();
  EXPECT_EQ(ordered_json::parse(out())["uses"], printed["uses"]);
  const std::string summary = read_file(folder_.file("result/summary.txt"));
  EXPECT_NE(summary.find("use by each contributor"), std::string::npos) << summary;
  std::istringstream lines(summary);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  EXPECT_EQ(run("solve path.json --set /solve/with/surfaces/0/psd/rms=-1"), 2);
  EXPECT_NE(err().find("/solve/with/surfaces/0/psd/rms"), std::string::npos) << err();
}

TEST_F(SolveCommand, OfCeilingsNeedsNoRoughness) {
  ordered_json study = ordered_json::parse(kStudy);
  study.erase("roughness");
  study["solve"].erase("for");
  study["solve"]["ceilings"] = {{"f_min", "20 /m"}, {"f_max", "80 /m"}, {"exponents", {1, 2}}};
  folder_.write("ceilings.json", study.dump());
  EXPECT_EQ(run("solve ceilings.json --json --quiet -o result"), 0) << err();
  const ordered_json printed = ordered_json::parse(out());
  EXPECT_EQ(printed["kind"], "ceilings");
  EXPECT_EQ(printed["octaves"].size(), 3u);
  EXPECT_EQ(printed["lines"][1]["profile_psd"]["B"], 2);
  EXPECT_EQ(printed, ordered_json::parse(read_file(folder_.file("result/result.json"))));
  folder_.write("resolved.json", printed["study"].dump());
  EXPECT_EQ(run("solve resolved.json --json --quiet -o again"), 0) << err();
  EXPECT_EQ(ordered_json::parse(out())["lines"], printed["lines"]);
  const std::string summary = read_file(folder_.file("result/summary.txt"));
  EXPECT_EQ(summary.find("CEILINGS: "), 0u) << summary;
  std::istringstream lines(summary);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  std::istringstream table(read_file(folder_.file("result/ceilings.csv")));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line, "frequency_per_m,rms_m,profile_psd_m3,binding");
  EXPECT_TRUE(std::filesystem::exists(folder_.file("result/plots/ceilings.gp")));
  // One question is out of reach, and two questions at once are refused.
  EXPECT_EQ(
      run("solve ceilings.json --set /target/theory=ghs --set '/solve/so_that/ee80_diameter=<= 0.1 arcsec'"),
      1);
  EXPECT_EQ(out().find("NO SOLUTION"), 0u) << out();
  EXPECT_EQ(run("solve study.json --set /solve/ceilings/f_max=80"), 2);
  EXPECT_NE(err().find("/solve/ceilings"), std::string::npos) << err();
  EXPECT_EQ(run("fit ceilings.json"), 2);
  EXPECT_NE(err().find("roughness"), std::string::npos) << err();
}

}  // namespace
}  // namespace aberfit
