// Tests columns of text: units from options and headers, holes, and messages with the place of a fault.
#include <gtest/gtest.h>

#include <cmath>

#include "../../src/measured/text_columns.h"
#include "aberfit/measured/read_measurement.h"
#include "mutation.h"

namespace aberfit::test {
using namespace internal;

namespace {

std::vector<Profile> read_text(const Scratch& scratch, const std::string& text, MeasuredSource source = {}) {
  source.path = scratch.write("a.csv", text);
  return read_profile_text(source);
}

TEST(ProfileText, EveryDelimiterGivesTheSameProfile) {
  const Scratch scratch;
  for (const std::string delimiter : {",", ";", "\t", " ", "   ", ", ", " ;"}) {
    SCOPED_TRACE("'" + delimiter + "'");
    const std::string d = delimiter;
    const auto profiles = read_text(scratch, "# made by hand\nx_mm" + d + "height_nm\n0" + d + "1.5\n\n1" +
                                                 d + "+2.5 # a remark\r\n2.25" + d + "-3e1");
    ASSERT_EQ(profiles.size(), 1u);
    const Profile& profile = profiles[0];
    ASSERT_EQ(profile.size(), 3);
    EXPECT_EQ(profile.quantity, ProfileQuantity::kHeight);
    EXPECT_EQ(profile.label, "height_nm");
    EXPECT_EQ(profile.x[2], 2.25 * 1e-3);
    EXPECT_EQ(profile.value[0], 1.5 * 1e-9);
    EXPECT_EQ(profile.value[1], 2.5 * 1e-9);
    EXPECT_EQ(profile.value[2], -30 * 1e-9);
  }
}

TEST(ProfileText, HeadersNameQuantityAndUnits) {
  const Scratch scratch;
  struct Case {
    const char* header;
    double x_factor;
    ProfileQuantity quantity;
    double value_factor;
  };
  constexpr auto kHeight = ProfileQuantity::kHeight, kSlope = ProfileQuantity::kSlope;
  const Case cases[] = {
      {"x_mm,height_nm", 1e-3, kHeight, 1e-9},
      {"x (mm),slope (urad)", 1e-3, kSlope, 1e-6},
      {"x[m],height [um]", 1, kHeight, 1e-6},
      {"# x [mm], height [nm]", 1e-3, kHeight, 1e-9},
      {"X(mm),SLOPE_ERROR[urad][W/B4C]", 1e-3, kSlope, 1e-6},
      {"x/mm,y/nm", 1e-3, kHeight, 1e-9},
      {"position_mm,signal_urad", 1e-3, kSlope, 1e-6},
      {"\"x (cm)\",\"sag (pm)\"", 1e-2, kHeight, 1e-12},
      {"# x_unit: mm\n# unit = urad\n# quantity: slope\nx,value", 1e-3, kSlope, 1e-6},
      {"# of: surface\nx_mm,height_nm", 1e-3, kHeight, 1e-9},
      {"# of: wavefront\nx_mm,height_nm", 1e-3, kHeight, 0.5e-9},
      {"# wavelength = 632.8 nm\nx_mm,height_waves", 1e-3, kHeight, 632.8e-9},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.header);
    const auto profiles = read_text(scratch, std::string(c.header) + "\n0,1\n1,2\n3,4\n");
    ASSERT_EQ(profiles.size(), 1u);
    EXPECT_EQ(profiles[0].quantity, c.quantity);
    // The product has a rounded factor.
    constexpr double kRounding = 2.3e-16;
    EXPECT_NEAR(profiles[0].x[2], 3 * c.x_factor, kRounding * 3 * c.x_factor);
    EXPECT_NEAR(profiles[0].value[2], 4 * c.value_factor, 4 * kRounding * c.value_factor);
  }
  // Names are separated by blanks, with units in brackets after a blank.
  const auto blanks = read_text(scratch, "x (mm) height (nm) slope [urad]\n0 1 5\n1 2 6\n");
  ASSERT_EQ(blanks.size(), 2u);
  EXPECT_EQ(blanks[0].quantity, kHeight);
  EXPECT_EQ(blanks[1].quantity, kSlope);
  EXPECT_EQ(blanks[1].value[1], 6 * 1e-6);
}

TEST(ProfileText, OptionsStandForTheHeaderAndMayNotContradictIt) {
  const Scratch scratch;
  MeasuredSource source;
  source.x_factor = 2;
  source.value_factor = 8;
  source.quantity = ProfileQuantity::kSlope;
  source.wavefront = true;
  const auto profile = read_text(scratch, "x,height\n0,1\n1,2\n", source).front();
  EXPECT_EQ(profile.quantity, ProfileQuantity::kSlope);
  EXPECT_EQ(profile.x[1], 2);
  EXPECT_EQ(profile.value[1], 8);  // 2 * 8, halved
  EXPECT_EQ(read_text(scratch, "0,1\n1,2\n", source).front().value[1], 8);
  for (const auto& [text, option] : {std::pair{"# of: surface\n0,1\n1,2\n", "option 'of'"},
                                     {"x_mm,height\n0,1\n1,2\n", "option 'x_unit'"},
                                     {"x,slope_urad\n0,1\n1,2\n", "option 'value_unit'"}})
    EXPECT_NE(input_error([&] { read_text(scratch, text, source); }).find(option), std::string::npos) << text;
}

TEST(ProfileText, HolesAndATrailingDelimiterAreUnderstood) {
  const Scratch scratch;
  const auto profiles =
      read_text(scratch, "x_mm,height_nm,height_nm\n0,,1\n1,nan,2\n2,--,\n3,NaN,3\n4,7,4\n5,8,5\n");
  ASSERT_EQ(profiles.size(), 2u);
  EXPECT_EQ(valid_count(profiles[0]), 2);
  EXPECT_EQ(valid_count(profiles[1]), 5);
  EXPECT_TRUE(std::isnan(profiles[1].value[2]));
  EXPECT_EQ(read_text(scratch, "x_mm,height_nm\n0,1,\n1,2,\n").size(), 1u);
  EXPECT_EQ(read_text(scratch, "\xef\xbb\xbfx_mm,height_nm\r0,1\r1,2\r").front().size(), 2);
}

TEST(ProfileText, EveryFaultIsToldWithItsPlaceOrOption) {
  const Scratch scratch;
  struct Case {
    std::string text, message;
  };
  const std::string h = "x_mm,height_nm\n";
  const Case cases[] = {
      {h + "0,1\n1,abc\n", "a.csv: line 3: found 'abc'; allowed: a number"},
      {h + "0,1\n1,-inf\n", "a.csv: line 3: found '-inf'; allowed: a finite number"},
      {h + "0,1\n1,0x10\n", "line 3: found '0x10'"},
      {"x_mm,height_nm,more_nm\n0,1\n1,2\n", "column 1: found positions without unit"},  // 3 names, 2 columns
      {h + "0,1\n1 2\n", "line 3: found '1 2'"},
      {h + "0,1\n1;2\n", "line 3: found '1;2'"},
      {h + "0,5;1,5\n1,5;2,5\n", "line 2: found '0,5'"},
      {h + "0,1\n1,2,3\n", "line 3: found 3 columns; allowed: 2 columns, as in line 2"},
      {h + "0,1\n0,2\n", "line 3: found position 0 twice"},
      {h + "0,1\n2,2\n1,2\n3,4\n", "line 4: found position 1 after 2"},
      {h + "3,1\n2,2\n2.5,2\n1,4\n", "line 4: found position 2.5 after 2"},
      {h + ",1\n2,2\n", "line 2: found a row without position"},
      {h + "1e999,1\n2,2\n", "line 2: found '1e999'"},
      {h + h + "0,1\n1,2\n", "line 2: found 'x_mm,height_nm'"},
      {h, "found no row of numbers"},
      {"", "found no row of numbers"},
      {h + "0,1\n", "found 1 row of numbers"},
      {"x_mm\n0\n1\n", "line 2: found 1 column;"},
      {"0,1\n1,2\n", "positions without unit; allowed: the option 'x_unit'"},
      {"x,height_nm\n0,1\n1,2\n", "column 1 'x': found positions without unit; allowed: the option 'x_unit'"},
      {"x_mm,height\n0,1\n1,2\n",
       "column 2 'height': found values without unit; allowed: the option 'value_unit'"},
      {"x_mm,value\n0,1\n1,2\n",
       "column 2 'value': found no statement whether it holds heights or slopes; allowed: the option "
       "'quantity'"},
      {"x_mm,height_nm,weight\n0,1,1\n1,2,1\n", "column 3 'weight': found no statement"},
      {"x_mm,slope (nm)\n0,1\n1,2\n", "column 2 'slope': found unit 'nm'; allowed: rad, mrad"},
      {"x_mm,height (parsec)\n0,1\n1,2\n", "column 2 'height': found unit 'parsec'; allowed: pm, nm"},
      {"x (urad),height_nm\n0,1\n1,2\n", "column 1 'x': found unit 'urad'"},
      {"x_mm,height_waves\n0,1\n1,2\n", "the option 'wavelength'"},
      {"# of: mirror\n" + h + "0,1\n1,2\n", "line 1: found 'mirror'; allowed: surface or wavefront"},
      {"# of: surface\n# of: wavefront\n" + h + "0,1\n1,2\n", "allowed: 'of' only once, as in line 1"},
      {"# wavelength = 5\nx_mm,height_waves\n0,1\n1,2\n",
       "line 1: found '5'; allowed: a length with its unit"},
      {"# quantity: charm\nx_mm,value_nm\n0,1\n1,2\n", "line 1: found 'charm'; allowed: height or slope"},
      {std::string("x_mm,hei\0ght\n0,1\n", 18), "line 1: found a zero byte"},
      {std::string("\xff\xfex\0_\0m\0m\0", 10), "found no row of numbers"},  // UTF-16
      {"0 1\n1 \xc3\xa4\x01\n", "line 2: found '\xc3\xa4?'"},
  };
  for (const Case& c : cases) {
    const std::string message = input_error([&] { read_text(scratch, c.text); });
    EXPECT_NE(message.find(c.message), std::string::npos) << "got: " << message << "\nwanted: " << c.message;
  }
  const auto with = [&](auto set) {
    MeasuredSource source;
    set(source);
    return input_error([&] { read_text(scratch, h + "0,1\n1,2\n", source); });
  };
  EXPECT_NE(with([](auto& s) { s.x_factor = -1; }).find("option 'x_unit': found -1"), std::string::npos);
  EXPECT_NE(with([](auto& s) { s.value_factor = 0; }).find("option 'value_unit': found 0"),
            std::string::npos);
  EXPECT_NE(with([](auto& s) { s.quantity = ProfileQuantity::kSlope; }).find("found"), std::string::npos);
  MeasuredSource folder;
  folder.path = scratch.path("");
  EXPECT_NE(input_error([&] { read_profile_text(folder); }).find("found no file"), std::string::npos);
}

TEST(ProfileText, EndlessLinesAndFilesAreRefusedBeforeTheyAreStored) {
  const Scratch scratch;
  // A billion zero bytes, sparse on the disc.
  const std::string sparse = scratch.write("sparse.csv", "x_mm,height_nm\n0,1\n");
  std::filesystem::resize_file(sparse, 1000000000);
  MeasuredSource source;
  source.path = sparse;
  EXPECT_NE(input_error([&] { read_profile_text(source); }).find("line 3: found a zero byte"),
            std::string::npos);
  const std::string message =
      input_error([&] { read_text(scratch, "x_mm,height_nm\n" + std::string(20000000, '1') + ",1\n"); });
  EXPECT_NE(message.find("line 2: found more than 16777216 characters"), std::string::npos) << message;
  // More numbers than the limit, which is small here.
  TextRules rules;
  rules.most_numbers = 5;
  const std::string path = scratch.write("many.csv", "1,2\n3,4\n5,6\n");
  EXPECT_NE(input_error([&] { read_text_table(path, rules); }).find("line 3: found more than 5 numbers"),
            std::string::npos);
  // More columns than any instrument has.
  std::string wide;
  for (int i = 0; i < 20000; ++i) wide += "1,";
  EXPECT_NE(input_error([&] { read_text(scratch, wide + "1\n"); }).find("line 1: found 20001 columns"),
            std::string::npos);
}

TEST(ProfileText, DamagedFilesAreReadOrRefused) {
  const Scratch scratch;
  std::string text = "# a scan\n# of: surface\nx (mm), height (nm), slope (urad)\n";
  for (int i = 0; i < 60; ++i)
    text += std::to_string(i * 0.5) + ", " + std::to_string(std::sin(0.3 * i)) + ", " +
            (i % 7 ? "0.25" : "nan") + "\n";
  MeasuredSource source;
  source.path = scratch.write("a.csv", text);
  const MutationCounts counts =
      read_mutations(text, source.path, 700, "ProfileText", [&] { read_profile_text(source); });
  EXPECT_GT(counts.read, 20);
  EXPECT_GT(counts.refused, 100);
}

}  // namespace
}  // namespace aberfit::test
