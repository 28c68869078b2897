// A study uses the units and kinds that a file of numbers states about itself.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "aberfit/report/psd_report.h"
#include "aberfit/report/scatter_table.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

// The keys after "# For `"model": "table"`:".
std::string keys_of_table(const std::string& csv) {
  const std::string mark = "# For `\"model\": \"table\"`: ";
  const std::size_t from = csv.find(mark);
  EXPECT_NE(from, std::string::npos) << csv.substr(0, 300);
  if (from == std::string::npos) return "";
  const std::size_t begin = from + mark.size();
  return csv.substr(begin, csv.find('\n', begin) - begin);
}

RadialPsd psd_of_a_study(const std::string& csv) {
  const std::filesystem::path folder = ::testing::TempDir(), table = folder / "written_hints_test.csv";
  std::ofstream(table) << csv;
  const std::string study =
      R"({"aberfit": 1, "mirror": {"focal_length": "2 m"}, "aperture": {"shape": "circle", "diameter": "0.4 m"},
        "light": {"wavelength": "600 nm"}, "roughness": {"psd": {"model": "table", "file": ")" +
      table.string() + "\", " + keys_of_table(csv) + "}}}";
  const RadialPsd psd(*parse_study(study, (folder / "study.json").string()).psd);
  std::filesystem::remove(table);
  return psd;
}

TEST(WrittenHints, OfScatterPsdAreTakenByAStudy) {
  const KCorrelationPsd rest{11e-9, 0.3, 2.8, 6, 400};
  const RadialPsd read = psd_of_a_study(scatter_psd_csv(rest, 600e-9)), written(rest);
  for (const double f : {7.0, 40.0, 300.0}) EXPECT_NEAR(read(f) / written(f), 1, 1e-3) << f;
}

TEST(WrittenHints, OfAnEstimateAreTakenByAStudy) {
  PsdReport report;
  SurfacePsd& s = report.surface;
  s.frequency = Eigen::ArrayXd::LinSpaced(5, 10, 50);
  s.psd = s.model = 1e-20 / s.frequency.square();
  s.low = s.frequency - 5;
  s.high = s.frequency + 5;
  s.lower = 0.8 * s.psd;
  s.upper = 1.2 * s.psd;
  s.dof = Eigen::ArrayXd::Constant(5, 9);
  const RadialPsd read = psd_of_a_study(psd_csv(report));
  for (Eigen::Index b = 1; b < 4; ++b) EXPECT_NEAR(read(s.frequency[b]) / s.psd[b], 1, 1e-6);
}

}  // namespace
}  // namespace aberfit
