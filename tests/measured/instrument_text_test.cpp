// Text formats of instruments: every sample must be where the description of the format places it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/measured/read_measurement.h"
#include "mutation.h"

namespace aberfit::test {
namespace {

// Heights [m] without any symmetry, with holes beyond a corner of the map.
constexpr int kColumns = 7, kRows = 5;
double truth(int column, int row) { return 1e-9 * (3 * column - 11 * row + 0.5 * column * row); }
bool hole(int column, int row) { return column + row > 8 || (column == 2 && row == 1); }

HeightMap read(const Scratch& scratch, const std::string& text, MeasuredSource source = {}) {
  source.path = scratch.write("map.txt", text);
  return std::get<HeightMap>(read_measurement(source));
}

// `rounding`: of the written numbers [m].
void expect_truth(const HeightMap& map, double pitch, double rounding) {
  ASSERT_EQ(map.columns(), kColumns);
  ASSERT_EQ(map.rows(), kRows);
  EXPECT_NEAR(map.pitch_x, pitch, 1e-12);
  EXPECT_NEAR(map.pitch_y, pitch, 1e-12);
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      const double height = map.height(row, column);
      if (hole(column, row))
        EXPECT_TRUE(std::isnan(height)) << column << " " << row;
      else
        EXPECT_NEAR(height, truth(column, row), rounding) << column << " " << row;
    }
}

std::string zygo_header(const std::string& title, int first_column = 0) {
  return title + "\n1 8 3 5 \"Tue Mar 03 10:00:00 2015\"\n0 0 0 0 0 0\n" +
         fmt::format("{} 0 {} {}\n", first_column, kColumns, kRows) +
         "\"a mirror\"\n\"1\"\n\"here\"\n0 0.5 6.328e-007 0 1 0 2.5e-04 1425376800\n"
         "640 480 0 0 0 0 \"\"\n0 1 10 5 0 0 0.1 0 2 50\n1 0 20 0 60 1 0 0 0\n0 \"\"\n1 0\n";
}

std::string zygo_xyz(int first_column = 0, double per_metre = 1e6) {
  std::string text = zygo_header("Zygo XYZ Data File - Format 1", first_column) + "#\n";
  for (int from_top = 0; from_top < kRows; ++from_top)
    for (int column = 0; column < kColumns; ++column) {
      const int row = kRows - 1 - from_top;
      text += fmt::format("{} {} ", column + first_column, from_top);
      text += hole(column, row) ? "No Data\n" : fmt::format("{:.9f}\n", per_metre * truth(column, row));
    }
  return text + "#\n";
}

// Counts of 1/32768 of half a wavelength, after a frame of intensity.
std::string zygo_ascii(int format, bool intensity) {
  std::string text = zygo_header(fmt::format("Zygo ASCII Data File - Format {}", format));
  if (format == 2) text += "\"1X\"\n";
  if (intensity) text.replace(text.find("0 0 0 0 0 0"), 11, "0 0 3 2 1 255");
  text += intensity ? "#\n12 13 14\n65535 3 4\n#\n" : "#\n#\n";
  int written = 0;
  for (int from_top = 0; from_top < kRows; ++from_top)
    for (int column = 0; column < kColumns; ++column) {
      const int row = kRows - 1 - from_top;
      const double count = 0.5 * 6.328e-7 / 32768;
      text += hole(column, row) ? "2147483640" : fmt::format("{:.0f}", truth(column, row) / count);
      text += ++written % 10 == 0 ? "\n" : " ";
    }
  return text + "\n#\n";
}

std::string wyko(bool nanometres) {
  std::string text = fmt::format("Wyko ASCII Data File Format 0\t{}\t1\nX Size\t{}\nY Size\t{}\n",
                                 nanometres ? 1 : 0, kColumns, kRows) +
                     "Block Name\tType\tLength\tValue\nTitle\t5\t20\ta flat\nWavelength\t7\t4\t600\n"
                     "Mult\t6\t2\t4\nPixel_size\t7\t4\t0.25\nIntensity\t3\t140\t\n";
  for (int i = 0; i < kColumns * kRows; ++i) text += "17 ";
  text += "\nRAW_DATA\t3\t140\t\n";
  const double unit = nanometres ? 1e-9 : 600e-9 / 4;
  for (int column = 0; column < kColumns; ++column)
    for (int row = 0; row < kRows; ++row)
      text += (hole(column, row) ? "Bad" : fmt::format("{:.9f}", truth(column, row) / unit)) +
              (row + 1 < kRows ? "\t" : "\n");
  return text;
}

TEST(ZygoText, XyzPointsComeBackInMicrometres) {
  const Scratch scratch;
  expect_truth(read(scratch, zygo_xyz()), 0.25e-3, 1e-15);
  // Columns count camera samples, of which the map is a part.
  expect_truth(read(scratch, zygo_xyz(130)), 0.25e-3, 1e-15);
  EXPECT_EQ(read(scratch, zygo_xyz()).label, "a mirror");
  MeasuredSource nanometres;
  nanometres.value_factor = 1e-9;
  expect_truth(read(scratch, zygo_xyz(0, 1e9), nanometres), 0.25e-3, 1e-17);
}

// Users give the mark of missing points as it stands in the file.
TEST(ZygoText, AMarkOfMissingPointsIsInTheUnitOfTheFile) {
  const Scratch scratch;
  std::string text = zygo_xyz();
  for (std::size_t at = 0; (at = text.find("No Data", at)) != std::string::npos;)
    text.replace(at, 7, "-9999.0");
  MeasuredSource source;
  source.invalid = {-9999};
  expect_truth(read(scratch, text, source), 2.5e-4, 1e-15);
  source.invalid = {-9998};
  EXPECT_EQ(valid_count(read(scratch, text, source)), kRows * kColumns);
}

TEST(ZygoText, CountsOfBothFormatsComeBackWithAndWithoutIntensity) {
  const Scratch scratch;
  for (const int format : {1, 2})
    for (const bool intensity : {false, true})
      expect_truth(read(scratch, zygo_ascii(format, intensity)), 0.25e-3, 0.25 * 6.328e-7 / 32768);
}

TEST(ZygoText, FaultsAreToldWithTheirPlace) {
  const Scratch scratch;
  const auto message = [&](std::string text, const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
    return input_error([&] { read(scratch, text); });
  };
  EXPECT_NE(message(zygo_xyz(), "No Data", "Nothing").find("Nothing'"), std::string::npos);
  EXPECT_NE(message(zygo_xyz(), "0 0 7 5", "0 0 7 9999999").find("line 4"), std::string::npos);
  const std::string whole = zygo_xyz();
  EXPECT_NE(
      input_error([&] { read(scratch, whole.substr(0, whole.size() - 2)); }).find("the end of the file"),
      std::string::npos);
  EXPECT_NE(message(zygo_ascii(2, false), "2147483640", "").find("34 phases"), std::string::npos);
  EXPECT_NE(message(zygo_ascii(2, false), "2147483640", "1.5").find("'1.5'"), std::string::npos);
  MeasuredSource other_pitch;
  other_pitch.pitch = 1e-3;
  EXPECT_NE(input_error([&] { read(scratch, zygo_xyz(), other_pitch); }).find("option 'pitch'"),
            std::string::npos);
}

TEST(WykoText, ColumnsComeBackInBothUnits) {
  const Scratch scratch;
  for (const bool nanometres : {false, true}) {
    const HeightMap map = read(scratch, wyko(nanometres));
    expect_truth(map, 0.25e-3, 1e-15);
    EXPECT_EQ(map.label, "a flat");
  }
  MeasuredSource angstroms;
  angstroms.value_factor = 1e-10;
  EXPECT_NE(input_error([&] { read(scratch, wyko(true), angstroms); }).find("option 'value_unit'"),
            std::string::npos);
  std::string cut = wyko(false);
  cut.resize(cut.size() - 30);
  EXPECT_NE(input_error([&] { read(scratch, cut); }).find("the end of the file"), std::string::npos);
}

TEST(Dftfringe, TheWavefrontIsHalvedAndLiesInItsEllipse) {
  // 9 x 9 samples, the lowest row first, on a disc of radius 4 about the middle sample.
  const Scratch scratch;
  constexpr int kSide = 9;
  const auto height = [](int column, int row) { return 1e-9 * (40 + 3 * column + 7 * row); };
  std::string text = "9\n9\n";
  const auto inside = [](int column, int row) { return std::hypot(column - 4, row - 4) <= 4; };
  for (int row = 0; row < kSide; ++row)
    for (int column = 0; column < kSide; ++column)
      text += inside(column, row) ? fmt::format("{:.8f}\n", 2 * height(column, row) / 550e-9) : "0.0\n";
  const std::string notes = "outside ellipse 4.0 4.0 4.0 4.0\nDIAM 200\nROC 1600\n";
  const HeightMap map = read(scratch, text + notes + "Lambda 550\n");
  EXPECT_NEAR(map.pitch_x, 0.2 / 8, 1e-12);
  for (int row = 0; row < kSide; ++row)
    for (int column = 0; column < kSide; ++column) {
      if (inside(column, row))
        EXPECT_NEAR(map.height(row, column), height(column, row), 3e-15) << column << " " << row;
      else
        EXPECT_TRUE(std::isnan(map.height(row, column)));
    }
  // Missing facts are requested, contradictions are refused.
  EXPECT_NE(input_error([&] { read(scratch, text + notes); }).find("option 'wavelength'"), std::string::npos);
  MeasuredSource source;
  source.path = scratch.write("map.txt", text + "Lambda 550\n");
  EXPECT_EQ(missing_facts(source), std::vector<std::string>{"pitch"});
  source.path = scratch.write("map.txt", text + notes + "Lambda 550\n");
  source.wavefront = false;
  EXPECT_NE(input_error([&] { read_measurement(source); }).find("option 'of'"), std::string::npos);
  EXPECT_NE(input_error([&] { read(scratch, text + notes + "Lambda 550\nregions 1\n"); }).find("'regions 1'"),
            std::string::npos);
}

TEST(GwyddionText, TheHeaderSaysSizeAndUnit) {
  const Scratch scratch;
  std::string text = "# Channel: Topography\n# Width: 8.00 mm\n# Height: 2.0 mm\n# Value units: \u00b5m\n";
  for (int from_top = 0; from_top < 4; ++from_top)
    for (int column = 0; column < 8; ++column)
      text += fmt::format("{}\t", column * column + 100 * from_top) + (column == 7 ? "\n" : "");
  MeasuredSource source;
  source.wavefront = false;
  const HeightMap map = read(scratch, text, source);
  EXPECT_NEAR(map.pitch_x, 1e-3, 1e-15);
  EXPECT_NEAR(map.pitch_y, 0.5e-3, 1e-15);
  EXPECT_NEAR(map.height(0, 3), 309e-6, 1e-15);  // the last line is the lowest row
  EXPECT_EQ(map.label, "Topography");
  source.path = scratch.path("map.txt");
  EXPECT_EQ(missing_facts(source), std::vector<std::string>());
  source.pitch = 2e-3;
  EXPECT_NE(input_error([&] { read_measurement(source); }).find("option 'pitch'"), std::string::npos);
  source.pitch.reset();
  source.value_factor = 1e-9;
  EXPECT_NE(input_error([&] { read_measurement(source); }).find("option 'value_unit'"), std::string::npos);
}

// A matrix with x in the first row and y in the first column.
std::string matrix_with_axes(double x0, double dx, double y0, double dy, const std::string& corner) {
  std::string text = corner;
  for (int column = 0; column < kColumns; ++column) text += fmt::format(" {:g}", x0 + dx * column);
  for (int row = 0; row < kRows; ++row) {
    text += fmt::format("\n{:g}", y0 + dy * row);
    for (int column = 0; column < kColumns; ++column)
      text += fmt::format(" {:.6f}", 1e9 * truth(column, row) + 5 * std::sin(7.0 * column * row + column));
  }
  return text + "\n";
}

TEST(MatrixWithAxes, PositionsAreNoHeights) {
  const Scratch scratch;
  MeasuredSource source;
  source.wavefront = false;
  source.x_factor = 1e-3;
  source.value_factor = 1e-9;
  const auto expected = [](int column, int row) {
    return truth(column, row) + 5e-9 * std::sin(7.0 * column * row + column);
  };
  for (const std::string corner : {"0", "nan", "-1"}) {
    const HeightMap up = read(scratch, matrix_with_axes(-20, 0.5, 1, 0.25, corner), source);
    ASSERT_EQ(up.columns(), kColumns);
    ASSERT_EQ(up.rows(), kRows);
    EXPECT_NEAR(up.pitch_x, 0.5e-3, 1e-12);
    EXPECT_NEAR(up.pitch_y, 0.25e-3, 1e-12);
    EXPECT_NEAR(up.x0, -20e-3, 1e-12);
    EXPECT_NEAR(up.height(3, 2), expected(2, 3), 1e-15);
    EXPECT_EQ(up.label, "positions in the first row and column");
    const HeightMap down = read(scratch, matrix_with_axes(-20, 0.5, 2, -0.25, corner), source);
    EXPECT_NEAR(down.height(kRows - 1 - 3, 2), expected(2, 3), 1e-15);
  }
  // Without a unit, the unit of the positions is requested; a pitch also determines it.
  source.x_factor.reset();
  source.path = scratch.write("map.txt", matrix_with_axes(-20, 0.5, 1, 0.25, "0"));
  EXPECT_EQ(missing_facts(source), std::vector<std::string>{"x_unit"});
}

TEST(MatrixWithAxes, PlanesAndOrdinaryMapsHaveNone) {
  const Scratch scratch;
  MeasuredSource source;
  source.wavefront = false;
  source.pitch = 1e-3;
  source.value_factor = 1e-9;
  source.format = MeasuredFormat::kMapText;
  std::string plane, noisy, labelled = "# layout: matrix\n" + matrix_with_axes(0, 1, 0, 1, "5");
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column) {
      plane += fmt::format("{} ", 3 * column - 2 * row) + (column == 5 ? "\n" : "");
      noisy += fmt::format("{:.3f} ", 3 * column - 2 * row + 0.4 * std::sin(17.0 * column + 29 * row)) +
               (column == 5 ? "\n" : "");
    }
  for (const std::string& text : {plane, noisy}) EXPECT_EQ(read(scratch, text, source).columns(), 6);
  EXPECT_EQ(read(scratch, labelled, source).columns(), kColumns + 1);
}

TEST(InstrumentText, AnyDamageIsReadOrRefused) {
  const Scratch scratch;
  const RandomStream stream(3, "InstrumentText");
  std::uint64_t number = 0;
  for (const std::string& original :
       {zygo_xyz(), zygo_ascii(2, true), wyko(false),
        std::string("3\n3\n0 1 2\n3 4 5\n6 7 8\noutside ellipse 1 1 2 2\nDIAM 20\nLambda 550\n")})
    for (int i = 0; i < 60; ++i) {
      const std::string text = mutated(original, stream, ++number);
      // Anything but an InputError fails the test.
      input_error([&] { read(scratch, text); });
    }
}

}  // namespace
}  // namespace aberfit::test
