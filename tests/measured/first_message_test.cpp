// The first message about a text file must give the cause: line, word and remedy.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/measured/read_measurement.h"
#include "mutation.h"

namespace aberfit::test {
namespace {

Measurement read(const Scratch& scratch, const std::string& text, MeasuredSource source = {}) {
  source.path = scratch.write("a.csv", text);
  return read_measurement(source);
}
Profile read_profile(const Scratch& scratch, const std::string& text, MeasuredSource source = {}) {
  return std::get<Profile>(read(scratch, text, source));
}

struct Refused {
  std::string text, message;
};

void expect_messages(const std::vector<Refused>& cases) {
  const Scratch scratch;
  for (const Refused& c : cases) {
    const std::string message = input_error([&] { read(scratch, c.text); });
    EXPECT_NE(message.find(c.message), std::string::npos) << "got: " << message << "\nwanted: " << c.message;
  }
}

TEST(FirstMessage, NamesADecimalComma) {
  expect_messages({{"s [mm];z [nm]\n0,0;39,6789\n0,1;40,6516\n", "line 2: found '0,0', a decimal comma"},
                   {"0,5;1,5\n1,5;2,5\n", "line 1: found '0,5', a decimal comma"},
                   {"x_mm\theight_nm\n0\t1,25\n1\t2,5\n", "line 2: found '1,25', a decimal comma"},
                   {"x height\n0,0 -1,5e-3\n0,1 2,5e-3\n", "line 2: found '0,0', a decimal comma"},
                   {"\"x\",\"z\"\n\"0,0\",\"1,5\"\n", "line 2: found '0,0', a decimal comma"},
                   {"1,5 2,5 3,5 4,5\n1,5 2,5 3,5 4,5\n", "line 1: found '1,5', a decimal comma"}});
}

TEST(FirstMessage, CommasThatSeparateAreNoDecimalCommas) {
  const Scratch scratch;
  for (const std::string text :
       {"x_mm,height_nm\n0,1\n1,2\n", "x_mm, height_nm\n0, 1\n1, 2\n", "x_mm ,height_nm\n0 ,1\n1 ,2\n"})
    EXPECT_EQ(read_profile(scratch, text).size(), 2) << text;
}

TEST(FirstMessage, NamesTheLineThatIsNoRowOfNumbers) {
  const std::string rows = "x_mm,height_nm\n0,1\n1,2\n";
  expect_messages(
      {{rows + "End of data\n", "line 4: found 'End of data'"},
       {rows + "Mean,3\n", "line 4: found 'Mean'"},
       {"0 1\n1 2\nTotal 7\n", "line 3: found 'Total'"},
       {"Instrument: LTP\nDate: today\nx_mm,height_nm\n0,1\n1,2\n", "line 2: found 'Date: today'"},
       {"0 1\n1 2 3\n", "line 2: found 3 columns"},
       {"1.5\n2.5\n3.5\n", "line 1: found 1 column; allowed: at least 2 columns"},
       {"height_nm\n1\n2\n", "line 2: found 1 column"},
       {"", "found an empty file"},
       {" \n\n\t\n", "found an empty file"},
       {"\xef\xbb\xbf", "found an empty file"},
       {"Dear all,\nthe mirror is fine.\n", "found text without a row of numbers"}});
}

TEST(TextTables, UnitsMayStandInARowOfTheirOwn) {
  const Scratch scratch;
  for (const std::string header :
       {"X;Z\n[mm];[nm]\n", "x;height\nmm;nm\n", "x;z\n(mm);(nm)\n", "\"X\";\"Z\"\n\"mm\";\"nm\"\n"}) {
    const Profile profile = read_profile(scratch, header + "0;1\n0.5;3\n1;2\n");
    EXPECT_EQ(profile.size(), 3) << header;
    EXPECT_NEAR(profile.x[1], 0.5e-3, 1e-18);
    EXPECT_NEAR(profile.value[1], 3e-9, 1e-23);
  }
  EXPECT_EQ(read_profile(scratch, "s\tslope\nmm\turad\n0\t1\n1\t2\n").quantity, ProfileQuantity::kSlope);
}

TEST(TextTables, CellsMayStandInQuotes) {
  const Scratch scratch;
  for (const std::string text : {"\"s [mm]\",\"z [nm]\"\n\"0.0\",\"1.5\"\n\"0.5\",\"2.5\"\n",
                                 "\"s, x [mm]\",z [nm]\n0.0,\"1.5\"\n0.5,2.5\n",
                                 "\"s [mm]\" \"z [nm]\"\n\"0.0\" \"1.5\"\n\"0.5\" \"2.5\"\n",
                                 "\"s [mm]\";\"z [nm]\"\n\"0.0\";\"1.5\"\n\"0.5\";\"2.5\"\n"}) {
    const Profile profile = read_profile(scratch, text);
    ASSERT_EQ(profile.size(), 2) << text;
    EXPECT_NEAR(profile.x[1], 0.5e-3, 1e-18) << text;
    EXPECT_NEAR(profile.value[1], 2.5e-9, 1e-23) << text;
  }
}

std::string utf16(const std::string& ascii, bool big_endian, bool mark) {
  std::string bytes = mark ? (big_endian ? "\xfe\xff" : "\xff\xfe") : "";
  for (const char c : ascii) bytes += big_endian ? std::string{'\0', c} : std::string{c, '\0'};
  return bytes;
}

TEST(TextTables, Utf16IsReadWithAndWithoutItsMark) {
  const Scratch scratch;
  std::string text = "x_mm,height_nm\r\n";
  for (int i = 0; i < 9000; ++i) text += fmt::format("{},{}\r\n", i, i % 7);  // longer than one read block
  for (const bool big_endian : {false, true})
    for (const bool mark : {false, true}) {
      const Profile profile = read_profile(scratch, utf16(text, big_endian, mark));
      ASSERT_EQ(profile.size(), 9000);
      EXPECT_NEAR(profile.x[8999], 8.999, 1e-12);
      EXPECT_NEAR(profile.value[13], 6e-9, 1e-22);
    }
}

TEST(TextTables, OtherSpellingsOfUnitsAndBlanksAreRead) {
  const Scratch scratch;
  struct Case {
    const char* header;
    double x, value;
  };
  for (const Case& c : {Case{"Position (mm),Height (\u00c5)", 1e-3, 1e-10},
                        Case{"Position (mm),Height (\xc5)", 1e-3, 1e-10},  // Windows-1252
                        Case{"Position (\xb5m),Height (nm)", 1e-6, 1e-9},  // Windows-1252
                        Case{"Position [microns],Height [Angstrom]", 1e-6, 1e-10},
                        Case{"Position (inches),Height (nanometers)", 0.0254, 1e-9},
                        Case{"Position\u00a0(mm),Height\u00a0(nm)", 1e-3, 1e-9},
                        Case{"# Position [ mm\u202f], Height [nm]", 1e-3, 1e-9}}) {
    const Profile profile = read_profile(scratch, std::string(c.header) + "\n0,1\n1,2\n");
    EXPECT_NEAR(profile.x[1] / c.x, 1, 1e-15) << c.header;
    EXPECT_NEAR(profile.value[1] / (2 * c.value), 1, 1e-15) << c.header;
  }
  EXPECT_EQ(read_profile(scratch, "x_mm;height_nm\n0\u00a0;\u00a01\n1;2\n").size(), 2);
  // The header and the option give different units.
  MeasuredSource source;
  source.value_factor = 1e-9;
  const std::string message =
      input_error([&] { read(scratch, "Position (mm),Height (\u00c5)\n0,1\n1,2\n", source); });
  EXPECT_NE(message.find("option 'value_unit'"), std::string::npos) << message;
  EXPECT_NE(message.find("\u00c5"), std::string::npos) << message;
}

TEST(RoundedPositions, APitchPutsThemInEqualSteps) {
  const Scratch scratch;
  const auto text = [](int digits, double step, int rows, bool descending) {
    std::string lines = "x_m,height_nm\n";
    for (int i = 0; i < rows; ++i)
      lines += fmt::format("{:.{}e},{}\n", (descending ? 0.42 : -0.42) + (descending ? -1 : 1) * i * step,
                           digits, i % 5);
    return lines;
  };
  for (const bool descending : {false, true})
    for (const double step : {0.995e-3, 0.35e-3, 1.013e-3}) {
      const std::string file = text(2, step, 400, descending);
      MeasuredSource source;
      source.pitch = step;
      const Profile profile = read_profile(scratch, file, source);
      ASSERT_EQ(profile.size(), 400);
      for (int i = 1; i < 400; ++i) EXPECT_NEAR(profile.x[i] - profile.x[i - 1], step, 1e-12);
      // No position is further off than its rounding in the file, half of 1e-3 m.
      const double first = descending ? 0.42 - 399 * step : -0.42;
      EXPECT_NEAR(profile.x[0], first, 0.5e-3);
      EXPECT_EQ(profile.value[descending ? 398 : 1], 1 * 1e-9);
      // A step that differs from that of the rows is refused.
      source.pitch = step * 1.02;
      EXPECT_NE(input_error([&] { read(scratch, file, source); }).find("option 'pitch'"), std::string::npos);
    }
  EXPECT_NE(input_error([&] { read(scratch, text(2, 0.35e-3, 400, false)); })
                .find("twice; allowed: each position once; where positions are rounded, their step as option "
                      "'pitch' (on average 350"),
            std::string::npos);
}

// With three digits, positions are rounded to 0.01 mm below 10 mm and to 1 mm above 100 mm.
TEST(RoundedPositions, MayBeRoundedMoreWhereTheyAreLarger) {
  const Scratch scratch;
  for (const double step : {0.3, 0.21, 0.07}) {
    std::string text = "x_mm,height_nm\n";
    for (int i = 0; i * step < 210; ++i) text += fmt::format("{:.2e},{}\n", i * step, i % 7);
    MeasuredSource source;
    source.pitch = step * 1e-3;
    const Profile profile = read_profile(scratch, text, source);
    for (Eigen::Index i = 1; i < profile.size(); ++i)
      ASSERT_NEAR(profile.x[i] - profile.x[i - 1], step * 1e-3, 1e-12);
    EXPECT_NEAR(profile.x[0], 0, 0.5e-3);
    source.pitch = step * 1.03e-3;
    EXPECT_NE(input_error([&] { read(scratch, text, source); }).find("equal steps"), std::string::npos);
  }
}

TEST(RoundedPositions, ALostRowIsNoRounding) {
  const Scratch scratch;
  std::string text = "x_mm,height_nm\n";
  for (int i = 0; i < 50; ++i)
    if (i != 20) text += fmt::format("{:.2f},1\n", 0.333 * i);
  MeasuredSource source;
  source.pitch = 0.333e-3;
  EXPECT_NE(input_error([&] { read(scratch, text, source); }).find("equal steps"), std::string::npos);
}

TEST(RoundedPositions, APitchAloneGivesPositionsAndTheirUnit) {
  const Scratch scratch;
  MeasuredSource source;
  source.pitch = 2e-3;
  const Profile one = read_profile(scratch, "height_nm\n1\n3\n2\n", source);
  ASSERT_EQ(one.size(), 3);
  EXPECT_NEAR(one.x[2], 4e-3, 1e-15);
  EXPECT_NEAR(one.value[1], 3e-9, 1e-20);
  const Profile counted = read_profile(scratch, "sample,height_nm\n10,1\n11,3\n12,2\n", source);
  EXPECT_NEAR(counted.x[2] - counted.x[0], 4e-3, 1e-15);
}

}  // namespace
}  // namespace aberfit::test
