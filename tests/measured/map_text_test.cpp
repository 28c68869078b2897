// Tests maps as text, a matrix or points: orientation, units, grids, and messages with the place of a fault.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "aberfit/measured/read_measurement.h"
#include "instrument_files.h"
#include "mutation.h"
#include "synthetic_files.h"

namespace aberfit::test {
namespace {

HeightMap read_text(const Scratch& scratch, const std::string& text, MeasuredSource source = {}) {
  source.path = scratch.write("a.txt", text);
  return read_map_text(source);
}

const std::string kKeys = "# of: surface\n# pitch = 0.1 mm\n# unit: nm\n";

TEST(MapText, FirstLineOfAMatrixIsTheTopRow) {
  const Scratch scratch;
  const HeightMap map = read_text(scratch, kKeys + "# label: a plate\n1 2 3 4\n5 -- nan 8\n9 10 11 12\n");
  ASSERT_EQ(map.rows(), 3);
  ASSERT_EQ(map.columns(), 4);
  EXPECT_EQ(map.height(0, 0), 9 * 1e-9);  // lowest y
  EXPECT_EQ(map.height(2, 3), 4 * 1e-9);  // top right
  EXPECT_EQ(map.height(1, 0), 5 * 1e-9);
  EXPECT_TRUE(std::isnan(map.height(1, 1)) && std::isnan(map.height(1, 2)));
  EXPECT_EQ(map.pitch_x, 0.1e-3);
  EXPECT_EQ(map.pitch_y, 0.1e-3);
  EXPECT_EQ(map.label, "a plate");
}

TEST(MapText, OptionsStandForTheHeader) {
  const Scratch scratch;
  MeasuredSource source;
  source.pitch = 0.5;
  source.value_factor = 4;
  source.wavefront = true;
  const HeightMap map = read_text(scratch, "1,2\n3,4\n", source);
  EXPECT_EQ(map.pitch_x, 0.5);
  EXPECT_EQ(map.height(0, 1), 8);  // 4 * 4, halved
  source.value_factor.reset();
  source.wavelength = 2;
  EXPECT_EQ(read_text(scratch, "# unit: waves\n1,2\n3,4\n", source).height(0, 1),
            4);  // 4 waves of 2 m, halved
  source.wavefront = false;
  EXPECT_NE(
      input_error([&] { read_text(scratch, kKeys + "1,2\n3,4\n", source); }).find("option 'pitch': found"),
      std::string::npos);
}

TEST(MapText, RowsMayGoOverSeveralLinesAndBeginAtTheBottom) {
  const Scratch scratch;
  MeasuredSource source;
  source.columns = 4;
  const HeightMap map = read_text(scratch, kKeys + "1 2 3\n4\n5 6\n7 8 9 10\n11 12\n", source);
  ASSERT_EQ(map.rows(), 3);
  ASSERT_EQ(map.columns(), 4);
  EXPECT_EQ(map.height(2, 3), 4 * 1e-9);
  EXPECT_EQ(map.height(0, 0), 9 * 1e-9);
  EXPECT_EQ(map.height(1, 1), 6 * 1e-9);
  const HeightMap commas = read_text(scratch, kKeys + "1,2,3,\n4,\n5,6,\n7,8,9,--,\n11,12\n", source);
  EXPECT_EQ(commas.height(1, 1), 6 * 1e-9);
  EXPECT_TRUE(std::isnan(commas.height(0, 1)));
  source.bottom_first = true;
  const HeightMap turned = read_text(scratch, kKeys + "1 2 3\n4\n5 6\n7 8 9 10\n11 12\n", source);
  EXPECT_EQ(turned.height(0, 3), 4 * 1e-9);
  EXPECT_EQ(turned.height(2, 0), 9 * 1e-9);
  const auto refused = [&](const MeasuredSource& by, const std::string& text) {
    return input_error([&] { read_text(scratch, text, by); });
  };
  source.columns = 5;
  EXPECT_NE(refused(source, kKeys + "1 2 3\n4 5 6\n").find("6 numbers in the file, 1 rows of 5 and 1 more"),
            std::string::npos);
  source.columns = 3;  // a matrix, although three columns are points elsewhere
  EXPECT_EQ(read_text(scratch, kKeys + "1 2 3\n4 5 6\n", source).rows(), 2);
  source.columns.reset();
  EXPECT_NE(refused(source, "# of: surface\n0 0 1\n1 0 1\n0 1 2\n1 1 2\n").find("option 'first_row'"),
            std::string::npos);
}

TEST(MapText, WrappedRowsAreAMapWhateverTheyLookLike) {
  const Scratch scratch;
  MeasuredSource source;
  source.columns = 4;
  source.path = scratch.write("a.txt", "# of: surface\n# unit: nm\n1 2 3\n4\n5 6 7\n8\n");
  source.pitch = 1e-3;
  EXPECT_EQ(std::get<HeightMap>(read_measurement(source)).columns(), 4);
  source.path = scratch.write("b.txt", "# of: surface\n# unit: nm\n1 2\n3 4\n5 6\n7 8\n");
  EXPECT_EQ(std::get<HeightMap>(read_measurement(source)).rows(), 2);
  source.format = MeasuredFormat::kProfileText;
  EXPECT_NE(input_error([&] { read_measurement(source); }).find("option 'columns'"), std::string::npos);
}

TEST(MapText, HeightsInWavesByTheOption) {
  const Scratch scratch;
  MeasuredSource source;
  source.pitch = 0.5;
  source.wavefront = true;
  source.value_in_waves = true;
  const std::string text = "1,2\n3,4\n";
  EXPECT_NE(input_error([&] { read_text(scratch, text, source); }).find("without a wavelength"),
            std::string::npos);
  source.wavelength = 500e-9;
  EXPECT_DOUBLE_EQ(read_text(scratch, text, source).height(0, 1), 4 * 500e-9 / 2);
  EXPECT_DOUBLE_EQ(read_text(scratch, "# unit: waves\n" + text, source).height(0, 1), 4 * 500e-9 / 2);
  EXPECT_NE(
      input_error([&] { read_text(scratch, "# unit: nm\n" + text, source); }).find("option 'value_unit'"),
      std::string::npos);
}

TEST(MissingFacts, AreAllFoundAtOnce) {
  const Scratch scratch;
  MeasuredSource source;
  source.path = scratch.write("a.txt", "1 2 3 4\n5 6 7 8\n9 8 7 6\n1 2 5 4\n");
  EXPECT_EQ(missing_facts(source), (std::vector<std::string>{"pitch", "of", "value_unit"}));
  source.value_in_waves = true;
  source.wavefront = false;
  EXPECT_EQ(missing_facts(source), (std::vector<std::string>{"pitch", "wavelength"}));
  source.pitch = 1;
  source.wavelength = 5e-7;
  EXPECT_TRUE(missing_facts(source).empty());
  source = {};
  source.path = scratch.write("b.txt", "0 1\n1 2\n2 3\n");
  EXPECT_EQ(missing_facts(source), (std::vector<std::string>{"x_unit", "quantity", "value_unit"}));
  source.path = scratch.path("none.txt");
  EXPECT_TRUE(missing_facts(source).empty());
}

TEST(MissingFacts, OfFilesOfInstrumentsAreAllFoundAtOnce) {
  using Facts = std::vector<std::string>;
  const Scratch scratch;
  const auto missing = [&](const std::string& name, const std::string& bytes) {
    return missing_facts(map_source(scratch.write(name, bytes)));
  };
  const std::string codev = "title\nGRD 3 2 SUR SSZ 1000\n1 2 3 4 5 6\n";
  EXPECT_EQ(missing("a.int", codev), (Facts{"wavelength", "pitch"}));
  MetroProFile zygo;
  zygo.wavelength = zygo.lateral = 0;
  EXPECT_EQ(missing("a.dat", zygo.bytes()), (Facts{"wavelength", "pitch"}));
  zygo.wavelength = 632.8f;  // damage is not a missing fact
  EXPECT_EQ(missing("a.dat", zygo.bytes()), Facts{});
  const std::string opd =
      replaced(replaced(file_bytes(instrument_file("marker-float.opd")), "Wavelength", "Wavelengtx"),
               "Pixel_size", "Pixel_sizX");
  EXPECT_EQ(missing("a.opd", opd), (Facts{"wavelength", "pitch"}));
  MeasuredSource source = map_source(scratch.path("a.opd"));
  source.value_factor = 1e-9;  // makes the wavelength unnecessary
  EXPECT_EQ(missing_facts(source), Facts{"pitch"});
  source.pitch = 1e-3;
  const double height = std::get<HeightMap>(read_measurement(source)).height(4, 4);
  source.value_factor = 3e-9;
  EXPECT_NEAR(std::get<HeightMap>(read_measurement(source)).height(4, 4) / height, 3, 1e-12);
}

// Options without effect are refused: these files define their heights and have no positions in text.
TEST(MapOptions, WithoutAUseAreRefused) {
  const Scratch scratch;
  std::string sag = "5 5 1 1 0 0 0\n";
  for (int i = 0; i < 25; ++i) sag += "1e-6 0 0 0\n";
  DabamFile dabam;
  dabam.rows = {{0, 1}, {1, 2}, {2, 1}, {3, 4}};
  for (const std::string& path :
       {scratch.write("a.dat", MetroProFile().bytes()),
        scratch.write("a.int", "title\nGRD 3 2 SUR WVL 0.5 SSZ 1000\n1 2 3 4 5 6\n"),
        scratch.write("sag.DAT", sag), dabam.write(scratch, "line"), instrument_file("marker-fringes.datx"),
        instrument_file("marker-nm.datx"), instrument_file("marker-float.opd"),
        instrument_file("marker-iso1.sdf"), instrument_file("marker-double.x3p")}) {
    SCOPED_TRACE(path);
    EXPECT_NO_THROW(read_measurement(map_source(path)));
    MeasuredSource waves = map_source(path), unit = waves, positions = waves;
    waves.value_in_waves = true;
    waves.wavelength = 632.8e-9;
    EXPECT_NE(input_error([&] { read_measurement(waves); }).find("option 'value_unit'"), std::string::npos);
    unit.value_factor = 7e-9;
    EXPECT_NE(input_error([&] { read_measurement(unit); }).find("option 'value_unit'"), std::string::npos);
    positions.x_factor = 1e-3;
    EXPECT_NE(input_error([&] { read_measurement(positions); }).find("option 'x_unit'"), std::string::npos);
  }
  MeasuredSource bottom = map_source(scratch.path("a.int"));
  bottom.bottom_first = true;
  EXPECT_NE(input_error([&] { read_measurement(bottom); }).find("option 'first_row'"), std::string::npos);
}

// Points of a disc on a 41 x 31 grid with positions rounded to three digits, in irregular order.
TEST(MapText, PointsInAnyOrderFindTheirNodes) {
  const Scratch scratch;
  constexpr int kColumns = 41, kRows = 31;
  constexpr double kStepX = 1.0 / 3, kStepY = 2.0 / 7;
  std::vector<std::string> lines;
  const auto inside = [](int i, int j) { return std::hypot((j - 20) / 20.0, (i - 15) / 15.0) <= 1; };
  for (int i = 0; i < kRows; ++i)
    for (int j = 0; j < kColumns; ++j) {
      if (!inside(i, j)) continue;
      char line[80];
      std::snprintf(line, sizeof line, "%.3f, %.3f, %d\n", (j - 20) * kStepX, (i - 15) * kStepY, 100 * i + j);
      lines.emplace_back(line);
    }
  const std::size_t count = lines.size();
  std::vector<std::string> shuffled;
  for (std::size_t k = 0; k < count; ++k) shuffled.push_back(lines[k * 389 % count]);
  ASSERT_NE(count % 389, 0u);
  std::string text = "# of: wavefront\nx_mm, y_mm, height_nm\n";
  for (const std::string& line : shuffled) text += line;
  const HeightMap map = read_text(scratch, text);
  ASSERT_EQ(map.rows(), kRows);
  ASSERT_EQ(map.columns(), kColumns);
  // Both ends are rounded to half a micrometre.
  constexpr double kEnd = 0.5e-6;
  EXPECT_NEAR(map.pitch_x, kStepX * 1e-3, 2 * kEnd / (kColumns - 1));
  EXPECT_NEAR(map.pitch_y, kStepY * 1e-3, 2 * kEnd / (kRows - 1));
  EXPECT_NEAR(map.x0, -20 * kStepX * 1e-3, kEnd);
  EXPECT_NEAR(map.y0, -15 * kStepY * 1e-3, kEnd);
  for (int i = 0; i < kRows; ++i)
    for (int j = 0; j < kColumns; ++j) {
      if (inside(i, j))
        ASSERT_DOUBLE_EQ(map.height(i, j), 0.5e-9 * (100 * i + j)) << i << " " << j;
      else
        ASSERT_TRUE(std::isnan(map.height(i, j))) << i << " " << j;
    }
}

TEST(MapText, PitchStandsForTheUnitOfPositions) {
  const Scratch scratch;
  MeasuredSource source;
  source.pitch = 0.25;
  const std::string points = "# of: surface\n# unit: nm\n10 5 1\n11 5 2\n12 5 3\n10 6 4\n11 6 5\n12 6 6\n";
  const HeightMap map = read_text(scratch, points, source);
  EXPECT_EQ(map.pitch_x, 0.25);
  EXPECT_EQ(map.pitch_y, 0.25);
  EXPECT_EQ(map.x0, 2.5);
  EXPECT_EQ(map.height(1, 2), 6 * 1e-9);
  // The key makes three columns a matrix.
  const HeightMap matrix = read_text(scratch, "# layout: matrix\n" + points, source);
  EXPECT_EQ(matrix.rows(), 6);
  EXPECT_EQ(matrix.columns(), 3);
}

TEST(MapText, EveryFaultIsToldWithItsPlaceOrOption) {
  const Scratch scratch;
  struct Case {
    std::string text, message;
  };
  const std::string p = "# of: surface\nx_mm,y_mm,height_nm\n";
  const std::string grid = "0,0,1\n1,0,2\n2,0,3\n0,1,4\n1,1,5\n2,1,6\n";
  const Case cases[] = {
      {kKeys + "1 2\n3 x\n", "a.txt: line 5: found 'x'; allowed: a number"},
      {kKeys + "1 2\n3 inf\n", "line 5: found 'inf'; allowed: a finite number"},
      {kKeys + "1 2\n3 4 5\n", "line 5: found 3 columns; allowed: 2 columns, as in line 4"},
      {kKeys + "1 2\n", "found 1 rows and 2 columns"},
      {kKeys + "nan nan\n-- nan\n", "found no height at all"},
      {"# unit: nm\n# of: surface\n1 2\n3 4\n", "allowed: the option 'pitch', or a header line"},
      {"# pitch = 1 mm\n# unit: nm\n1 2\n3 4\n",
       "allowed: the option 'of', or a header line '# of: surface'"},
      {"# pitch = 1 mm\n# of: surface\n1 2\n3 4\n", "allowed: the option 'value_unit', or a header line"},
      {"# pitch = 1\n# of: surface\n# unit: nm\n1 2\n3 4\n",
       "line 1: found '1'; allowed: a length with its unit"},
      {"# pitch = -1 mm\n# of: surface\n# unit: nm\n1 2\n3 4\n",
       "line 1: found '-1 mm'; allowed: a length above"},
      {"# pitch = 1 mm\n# of: surface\n# unit: furlong\n1 2\n3 4\n", "unit 'furlong'; allowed: pm, nm"},
      {"# layout: spiral\n" + kKeys + "1 2\n3 4\n",
       "line 1: found 'spiral'; allowed: 'matrix', or 'columns'"},
      {p + grid + "2,1,7\n", "line 9: found the point (2, 1) twice"},
      {p + grid + "1.3,1,7\n", "regular grid (the others have the step"},
      {p + grid + "1.00001,1,7\n", "at least 1 %"},
      {p + "0,0,1\n3,0,2\n6,0,3\n0,1,4\n3,1,5\n6,1,6\n4.9,1,7\n", "regular grid"},
      {p + "0,0,1\n1e-3,1,2\n1,1e-3,3\n", "found 3 points for a grid of 1001 x 1001"},
      {p + "0,0,1\n1e-300,1,2\n1e300,1e-3,3\n", "grid"},
      {p + "0,0,1\n0,1,2\n0,2,3\n", "column x: found only one position"},
      {p + "-1.7e308,0,1\n1.7e308,1,2\n0,2,3\n", "column x: found an infinite range"},
      {p + "0,nan,1\n0,1,2\n1,2,3\n", "line 3: found a row without position"},
      {"# of: surface\nx,y,height_nm\n" + grid,
       "column 1: found positions without unit; allowed: the option"},
      {"# of: surface\nx_mm,y_mm,slope_urad\n" + grid, "column 3: found 'slope'"},
      {"# pitch: 5 mm\n" + p + grid, "a step of 0.001 m and a pitch of 0.005 m"},
      {"", "found no row of numbers"},
  };
  for (const Case& c : cases) {
    const std::string message = input_error([&] { read_text(scratch, c.text); });
    EXPECT_NE(message.find(c.message), std::string::npos) << "got: " << message << "\nwanted: " << c.message;
  }
  MeasuredSource source;
  source.pitch = NAN;
  EXPECT_NE(input_error([&] {
              read_text(scratch, kKeys + "1 2\n3 4\n", source);
            }).find("option 'pitch': found nan"),
            std::string::npos);
}

TEST(MapText, DamagedFilesAreReadOrRefused) {
  const Scratch scratch;
  std::string matrix = kKeys, points = "# of: surface\nx_mm;y_mm;height_nm\n";
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 9; ++j) {
      matrix += std::to_string(i * j % 7 - 3.5) + (j == 8 ? "\n" : "\t");
      points += std::to_string(0.5 * j) + ";" + std::to_string(0.25 * i) + ";" + std::to_string(i - j) + "\n";
    }
  }
  MeasuredSource source;
  source.path = scratch.path("a.txt");
  for (const std::string& text : {matrix, points}) {
    const MutationCounts counts =
        read_mutations(text, source.path, 500, "MapText", [&] { read_map_text(source); });
    EXPECT_GT(counts.read, 20);
    EXPECT_GT(counts.refused, 100);
  }
}

}  // namespace
}  // namespace aberfit::test
