// NaN and infinity as old Windows programs write them, and '#' inside a word, must not become heights.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "aberfit/core/text.h"
#include "aberfit/measured/clear_aperture.h"
#include "aberfit/measured/focal_data.h"
#include "aberfit/measured/read_measurement.h"
#include "aberfit/roughness/psd_table.h"
#include "mutation.h"

namespace aberfit::test {
namespace {

// Written by printf of Visual C++ up to 2013 for %g, %f, %.3f, %.2f and %e.
const std::vector<std::string> kWords = {"1.#QNAN",  "-1.#IND",  "1.#INF",        "-1.#INF", "1.#SNAN",
                                         "1.#QNAN0", "1.#QO",    "1.#R",          "1.#J",    "-1.#IND00",
                                         "1.#INF00", "1.#QNANE", "1.#QNAN0e+000", "+1.#INF", "1.#qnan"};

TEST(OldWindowsNumbers, AreNoNumbers) {
  for (const std::string& word : kWords) {
    const std::optional<double> value = parse_number<double>(word);
    EXPECT_TRUE(value && std::isnan(*value)) << word;
    EXPECT_FALSE(parse_finite(word)) << word;
  }
  for (const std::string word : {"1.#", "1.#5", "2.#QNAN", "1#QNAN", "1.#QNAN x", "#QNAN", "1.", "1.$"})
    EXPECT_FALSE(is_old_windows_nan(word)) << word;
}

TEST(OldWindowsNumbers, ACommentBeginsFirstInALineOrBehindABlank) {
  EXPECT_EQ(before_comment("# all"), "");
  EXPECT_EQ(before_comment("1 2 # rest # more"), "1 2 ");
  EXPECT_EQ(before_comment("1\t#"), "1\t");
  EXPECT_EQ(before_comment("1.#INF 2#3"), "1.#INF 2#3");
  EXPECT_EQ(before_comment("1.#INF #3"), "1.#INF ");
  EXPECT_EQ(before_comment(""), "");
}

TEST(OldWindowsNumbers, AreHolesOfProfiles) {
  const Scratch scratch;
  for (const std::string& word : kWords)
    for (const std::string delimiter : {" ", ";", ",", "\t"}) {
      std::string text = "x_mm" + delimiter + "height_nm\n";
      for (int i = 0; i < 6; ++i)
        text += std::to_string(i) + delimiter + (i == 3 ? word : std::to_string(10 + i)) + " # row\n";
      MeasuredSource source;
      source.path = scratch.write("a.csv", text);
      const Profile profile = std::get<Profile>(read_measurement(source));
      ASSERT_EQ(profile.size(), 6);
      EXPECT_EQ(valid_count(profile), 5) << word;
      EXPECT_TRUE(std::isnan(profile.value[3])) << word;
      EXPECT_EQ(profile.value[4], 14 * 1e-9);
    }
}

TEST(OldWindowsNumbers, AreHolesOfMapsInRowsAndInPoints) {
  const Scratch scratch;
  const std::string keys = "# of: surface\n# pitch = 0.1 mm\n# unit: nm\n";
  for (const std::string& word : kWords) {
    MeasuredSource source;
    source.path = scratch.write("a.txt", keys + "1 2 3 4\n5 " + word + " 7 8\n9 10 11 " + word + "\n");
    const HeightMap matrix = std::get<HeightMap>(read_measurement(source));
    EXPECT_EQ(valid_count(matrix), 10) << word;
    EXPECT_TRUE(std::isnan(matrix.height(1, 1)) && std::isnan(matrix.height(0, 3))) << word;
    EXPECT_EQ(matrix.height(1, 2), 7 * 1e-9);
    source.path =
        scratch.write("b.txt", "# of: surface\nx_mm,y_mm,height_nm\n0,0,1\n1,0," + word + "\n0,1,3\n1,1,4\n");
    const HeightMap points = std::get<HeightMap>(read_measurement(source));
    EXPECT_TRUE(std::isnan(points.height(0, 1))) << word;
    EXPECT_EQ(valid_count(points), 3) << word;
  }
}

TEST(OldWindowsNumbers, AreLeftOutByAMask) {
  const Scratch scratch;
  const Grid mask = read_mask(scratch.write("mask.txt", "1 1 1.#QNAN0\n1 -1.#IND00 1\n"));
  EXPECT_EQ(mask.isNaN().count(), 2);
  EXPECT_TRUE(std::isnan(mask(1, 2)) && std::isnan(mask(0, 1)));
}

// A missing value gives an error with line and word if no value may be missing.
TEST(OldWindowsNumbers, AreToldWhereAHoleIsNotAllowed) {
  const Scratch scratch;
  for (const std::string word : {"1.#QNAN0", "-1.#IND00", "1.#INF"}) {
    const std::string table = scratch.write("psd.csv", "f,psd\n1,4\n2," + word + "\n3,1\n");
    const std::string told = input_error([&] { read_psd_table(table, {}); });
    EXPECT_NE(told.find("line 3: '" + word + "'"), std::string::npos) << told;
    const std::string position = scratch.write("a.csv", "x_mm,height_nm\n0,1\n" + word + ",2\n2,3\n");
    MeasuredSource source;
    source.path = position;
    source.format = MeasuredFormat::kProfileText;
    EXPECT_NE(input_error([&] { read_measurement(source); }).find("line 3"), std::string::npos);
    const std::string curve = scratch.write("curve.csv", "radius_um,share\n1,0.2\n2," + word + "\n3,0.8\n");
    EXPECT_NE(input_error([&] { read_encircled_curve(curve, ""); }).find("line 3"), std::string::npos);
  }
}

}  // namespace
}  // namespace aberfit::test
