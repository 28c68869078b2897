#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "aberfit/commands/run.h"
#include "aberfit/report/documents.h"
#include "aberfit/study/read_study.h"
#include "study/scratch_folder.h"

namespace aberfit::test {
namespace {

// A study whose roughness is `psd`, a psd block in JSON.
std::string study_of(const std::string& psd) {
  return R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
             "aperture": {"shape": "circle", "diameter": "0.4 m"}, "roughness": {"psd": )" +
         psd + R"(}, "terms": {"zernike": {"n_max": 8}}})";
}

// Message of the warning `code` that `check` gives; empty when it gives none.
std::string warning_of(const std::string& psd, const std::string& code) {
  const ScratchFolder folder;
  // Log-log interpolation of a table is exact for a power law: S = 1e-17 f^-3, 10 to 1000 /m.
  folder.write("law.csv", "f_per_m,psd_m4\n10,1e-20\n100,1e-23\n1000,1e-26\n");
  // A profile PSD that rises by 100 between its last points but one.
  folder.write("rising.csv", "f_per_m,psd_m3\n10,1e-17\n20,1e-18\n40,1e-19\n80,1e-17\n160,1e-20\n");
  const Study study = parse_study(study_of(psd), folder.file("study.json"));
  const nlohmann::ordered_json result = to_json(run_check(study, {}), resolved_study(study));
  for (const auto& warning : result.at("warnings"))
    if (warning.at("code") == code) return warning.at("message");
  return "";
}

TEST(TableWarnings, SayWhichSharesOfHeightAndSlopeABandCutLeavesOut) {
  // Variance of the height in a band: int f^-2 df = 1/a - 1/b; of the slope: int f^0 df = b - a.
  const double height = 1 - (1 / 20.0 - 1 / 200.0) / (1 / 10.0 - 1 / 1000.0);
  const double slope = 1 - (200.0 - 20.0) / (1000.0 - 10.0);
  EXPECT_EQ(
      warning_of(R"({"model": "table", "file": "law.csv", "f_min": "20 /m", "f_max": "200 /m"})", "band-cut"),
      fmt::format("the band 20 to 200 /m of \"law.csv\" leaves out {:.1f} % of the table's height variance "
                  "and {:.1f} % of its slope variance; slopes determine the focus by rays",
                  100 * height, 100 * slope));
  EXPECT_NEAR(height, 0.545, 1e-3);
  EXPECT_NEAR(slope, 0.818, 1e-3);
}

TEST(TableWarnings, FindTheTablesInsideSums) {
  const std::string cut = R"({"model": "table", "file": "law.csv", "f_max": "100 /m"})";
  const std::string floor = R"({"model": "uniform", "rms": "1 nm", "f_min": "10 /m", "f_max": "20 /m"})";
  EXPECT_NE(warning_of(R"({"model": "sum", "parts": [)" + floor + ", " + cut + "]}", "band-cut"), "");
}

TEST(TableWarnings, AreSilentAboutWholeTables) {
  const std::string whole = R"({"model": "table", "file": "law.csv"})";
  EXPECT_EQ(warning_of(whole, "band-cut"), "");
  EXPECT_EQ(warning_of(whole, "psd-points-left-out"), "");
}

TEST(TableWarnings, CountThePointsWhereAProfilePsdRises) {
  const std::string message =
      warning_of(R"({"model": "table", "file": "rising.csv", "kind": "1d"})", "psd-points-left-out");
  EXPECT_NE(message.find("of \"rising.csv\" left out: the profile PSD rises there"), std::string::npos)
      << message;
}

}  // namespace
}  // namespace aberfit::test
