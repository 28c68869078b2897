// Warnings of `fit` about a map: its size relative to the aperture, and exports that are not possible.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/random.h"
#include "aberfit/measured/write_map.h"
#include "aberfit/study/read_study.h"
#include "study/scratch_folder.h"

namespace aberfit::test {
namespace {

// A map with a point per millimetre within 24 mm and 10 nm of white noise.
HeightMap round_map() {
  HeightMap map;
  map.pitch_x = map.pitch_y = 1e-3;
  map.height = Grid::Constant(49, 49, std::nan(""));
  centre_on_grid(&map);
  const RandomStream stream(1, "map-warnings-test");
  for (Eigen::Index i = 0; i < map.rows(); ++i)
    for (Eigen::Index k = 0; k < map.columns(); ++k)
      if (std::hypot(map.x(k), map.y(i)) < 24.0001e-3)
        map.height(i, k) = 10e-9 * stream.normal(std::uint64_t(i * map.columns() + k));
  return map;
}

struct Fit {
  ScratchFolder folder;
  ResultDocument result;

  Fit(double diameter_mm, const std::string& terms, const std::string& exports = "") {
    folder.write("map.csv", map_csv(round_map()));
    const std::string text = fmt::format(
        R"({{"aberfit": 1, "mirror": {{"focal_length": "1 m"}}, "light": {{"wavelength": "632.8 nm"}},
             "aperture": {{"shape": "circle", "diameter": "{} mm"}}, "trace": {{"rays": 1024}},
             "target": {{"map": {{"file": "map.csv", "origin": "file"}}}}, "terms": {{{}}},
             "output": {{"pictures": "none", "export": [{}], "export_grid": 17}}}})",
        diameter_mm, terms, exports);
    const Study study = parse_study(text, folder.write("study.json", text));
    RunOptions options;
    options.threads = 1;
    options.pictures = PictureFormat::kNone;
    if (!exports.empty()) options.output_directory = folder.file("out");
    result = run_map_fit(study, options);
  }
  std::vector<std::string> messages(const std::string& code) const {
    std::vector<std::string> found;
    for (const Warning& warning : result.warnings)
      if (warning.code == code) found.push_back(warning.message);
    return found;
  }
  bool exported(const std::string& name) const {
    return std::filesystem::exists(folder.file("out/exports/" + name));
  }
};

bool has(const std::vector<std::string>& messages, const std::string& word) {
  return messages.size() == 1 && messages[0].find(word) != std::string::npos;
}

TEST(MapWarnings, MapSmallerThanApertureBelow98Percent) {
  const std::string terms = R"("zernike": {"n_max": 4})";
  const Fit smaller(48 / 0.979, terms), same(48 / 0.981, terms);
  EXPECT_TRUE(has(smaller.messages("map-smaller-than-aperture"), "extrapolated"));
  EXPECT_TRUE(same.messages("map-smaller-than-aperture").empty());
}

// rho^4 is a sum of the Zernikes beside it, so the points determine only their sum.
TEST(MapWarnings, ExportLeftOutWhereTheMapDoesNotDetermineTheTerms) {
  const std::string both = R"("zernike": {"n_max": 4}, "spherical": ["c4"])";
  const Fit unknown(48.1, both, R"("csv")"), known(48.1, R"("zernike": {"n_max": 4})", R"("csv")");
  EXPECT_TRUE(has(unknown.messages("export-left-out"), "do not determine the terms"));
  EXPECT_FALSE(unknown.exported("surface.csv"));
  EXPECT_TRUE(known.messages("export-left-out").empty());
  EXPECT_TRUE(known.exported("surface.csv"));
  // If no export is requested, no warning says that one is left out.
  EXPECT_TRUE(Fit(48.1, both).messages("export-left-out").empty());
}

// Zernike Standard ends at n = 20. An order in the study file is refused when it is read. An order that comes
// later, from a program or from a fit, leaves this format out and writes the others. The warning comes before
// the fit in both cases.
TEST(MapWarnings, AFormatThatCannotHoldTheTermsIsRefused) {
  const std::string formats = R"("zernike-noll", "csv")";
  EXPECT_THROW(Fit(48.1, R"("zernike": {"n_max": 21})", formats), InputError);
  const Fit within(48.1, R"("zernike": {"n_max": 20})", formats);
  EXPECT_TRUE(within.messages("export-left-out").empty());
  EXPECT_TRUE(within.exported("zernike_standard.txt"));
}

}  // namespace
}  // namespace aberfit::test
