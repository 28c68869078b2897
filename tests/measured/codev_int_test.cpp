#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "aberfit/measured/read_measurement.h"
#include "aberfit/measured/write_map.h"
#include "map_mutation.h"
#include "map_samples.h"

namespace aberfit {
namespace {

using test::contains;
using test::refusal;
using test::ScratchFolder;

constexpr double kWavelength = 632.8e-9;

HeightMap read_text(const std::string& text, const std::function<void(MeasuredSource*)>& options = {}) {
  const ScratchFolder folder;
  MeasuredSource source;
  source.path = folder.write("map.int", text);
  if (options) options(&source);
  return read_codev_int(source);
}

// A minimal independent reader: title, header in the order that CODE V documents, numbers; top row first.
HeightMap independent(const std::string& text) {
  std::istringstream in(text);
  std::string title, grd, type, wvl, ssz, nda;
  std::getline(in, title);
  int nx = 0, ny = 0;
  double wavelength_um = 0, scale = 0;
  long mark = 0;
  in >> grd >> nx >> ny >> type >> wvl >> wavelength_um >> ssz >> scale >> nda >> mark;
  EXPECT_EQ(grd + type + wvl + ssz + nda, "GRDSURWVLSSZNDA");
  std::string rest;
  std::getline(in, rest);
  HeightMap map;
  map.height = Grid(ny, nx);
  for (int r = ny - 1; r >= 0; --r)
    for (int c = 0; c < nx; ++c) {
      long value = 0;
      in >> value;
      EXPECT_LE(std::abs(value), 32767);
      map.height(r, c) = value == mark ? std::nan("") : double(value) * wavelength_um * 1e-6 / scale;
    }
  EXPECT_TRUE(bool(in));
  return map;
}

double largest(const HeightMap& map) {
  double most = 0;
  for (const double h : map.height.reshaped())
    if (std::isfinite(h)) most = std::max(most, std::abs(h));
  return most;
}

TEST(CodeVInt, FirstNumberCountsThePointsAlongXAndTheTopRowComesFirst) {
  const HeightMap map = read_text("title\r\nGRD 3 2 SUR WVL 0.5 SSZ 1000\r\n1 2 3\r\n4 5 6\r\n");
  ASSERT_EQ(map.columns(), 3);
  ASSERT_EQ(map.rows(), 2);
  EXPECT_EQ(map.label, "title");
  const double unit = 0.5e-6 / 1000;
  EXPECT_NEAR(map.height(1, 0), 1 * unit, 1e-24);
  EXPECT_NEAR(map.height(1, 2), 3 * unit, 1e-24);
  EXPECT_NEAR(map.height(0, 0), 4 * unit, 1e-24);
  EXPECT_EQ(map.pitch_x, 0);
}

TEST(CodeVInt, ReadsCommentsFreeLineBreaksAndAnyLineEnd) {
  const std::string text =
      "! made by hand\n!\nA title\nGRD 3 2 SUR WVL 0.5 NNB SSZ 1000 NDA -9\n1 2\n3 4 -9\n\n6";
  const HeightMap map = read_text(text);
  std::string dos, mac;
  for (const char c : text) dos += c == '\n' ? "\r\n" : std::string(1, c), mac += c == '\n' ? '\r' : c;
  test::expect_same_map(read_text(dos + "\r\n\x1a"), map, 0);
  test::expect_same_map(read_text(mac), map, 0);
  EXPECT_TRUE(std::isnan(map.height(0, 1)));
  EXPECT_NEAR(map.height(0, 2), 6 * 0.5e-9, 1e-24);
  EXPECT_EQ(map.label, "A title");
  // The title may be blank or missing.
  EXPECT_EQ(read_text("\nGRD 2 1 SUR WVL 1 SSZ 1\n1 2\n").columns(), 2);
  // A title that looks like a header is still a title.
  EXPECT_EQ(read_text("GRD 9 9 old\nGRD 2 1 SUR WVL 1 SSZ 1\n1 2\n").columns(), 2);
}

TEST(CodeVInt, NoDataIs32767UnlessNdaSaysOtherwise) {
  const HeightMap map = read_text("t\nGRD 2 1 SUR WVL 1 SSZ 1\n32767 -32768\n");
  EXPECT_TRUE(std::isnan(map.height(0, 0)));
  EXPECT_TRUE(std::isfinite(map.height(0, 1)));
  const HeightMap prysm = read_text("t\nGRD 2 1 SUR WVL 1 SSZ 1 NDA -32768\n32767 -32768\n");
  EXPECT_TRUE(std::isfinite(prysm.height(0, 0)));
  EXPECT_TRUE(std::isnan(prysm.height(0, 1)));
}

TEST(CodeVInt, WavefrontIsHalvedToTheSurfaceAndNoOptionContradicts) {
  const std::string sur = "t\nGRD 2 1 SUR WVL 1 SSZ 1\n10 20\n", wfr = "t\nGRD 2 1 WFR WVL 1 SSZ 1\n10 20\n";
  const auto say = [](bool wavefront) { return [=](MeasuredSource* s) { s->wavefront = wavefront; }; };
  EXPECT_NEAR(read_text(sur).height(0, 1), 20e-6, 1e-20);
  EXPECT_NEAR(read_text(wfr).height(0, 1), 10e-6, 1e-20);
  EXPECT_NEAR(read_text(wfr, say(true)).height(0, 1), 10e-6, 1e-20);
  EXPECT_EQ(refusal([&] { read_text(sur, say(true)); }).pointer(), "option 'of'");
  EXPECT_EQ(refusal([&] { read_text(wfr, say(false)); }).found(), "surface");
  const auto other = [](MeasuredSource* s) { s->wavelength = 1.002e-6; };
  EXPECT_EQ(refusal([&] { read_text(sur, other); }).pointer(), "option 'wavelength'");
}

TEST(CodeVInt, PitchComesFromTheOptionAndXscStretchesTheColumns) {
  const auto pitch = [](MeasuredSource* s) { s->pitch = 2e-3; };
  const HeightMap square = read_text("t\nGRD 3 2 SUR WVL 1 SSZ 1\n1 2 3 4 5 6\n", pitch);
  EXPECT_EQ(square.pitch_x, 2e-3);
  EXPECT_EQ(square.pitch_y, 2e-3);
  EXPECT_NEAR(square.x0, -2e-3, 1e-18);
  // The width is 3 times the height of 2 x 2 mm, in three columns.
  const HeightMap wide = read_text("t\nGRD 3 2 SUR WVL 1 SSZ 1 XSC 3\n1 2 3 4 5 6\n", pitch);
  EXPECT_NEAR(wide.pitch_x, 4e-3, 1e-18);
  EXPECT_EQ(wide.pitch_y, 2e-3);
}

TEST(CodeVInt, WavelengthMayComeFromTheOption) {
  const std::string text = "t\nGRD 2 1 SUR SSZ 10\n10 20\n";
  const InputError error = refusal([&] { read_text(text); });
  EXPECT_EQ(error.pointer(), "GRD");
  EXPECT_TRUE(contains(error.allowed(), "option 'wavelength'"));
  EXPECT_NEAR(read_text(text, [](MeasuredSource* s) { s->wavelength = 1e-6; }).height(0, 1), 2e-6, 1e-20);
}

TEST(CodeVInt, RoundTripsThroughBothReaders) {
  // Maps around zero, above and below it. A scale from the signed maximum would fail for the last.
  for (const double offset : {0.0, 3e-6, -3e-6})
    for (const auto& [rows, columns] : {std::pair{5, 9}, std::pair{12, 6}, std::pair{40, 40}}) {
      const HeightMap map = test::marker_map(rows, columns, 1e-3, offset);
      const std::string text = codev_int_text(map, kWavelength, "round trip");
      const double bound = largest(map) / 65000;
      test::expect_same_map(read_text(text), map, bound);
      test::expect_same_map(independent(text), map, bound);
      const HeightMap scaled = read_text(text, [](MeasuredSource* s) { s->pitch = 1e-3; });
      EXPECT_NEAR(scaled.pitch_x, 1e-3, 1e-11);
      // Records have at most 80 characters and end with CR LF.
      for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = text.find('\n', begin);
        ASSERT_NE(end, std::string::npos);
        ASSERT_EQ(text[end - 1], '\r');
        EXPECT_LE(end - 1 - begin, 80u);
        begin = end + 1;
      }
    }
}

TEST(CodeVInt, WritesAZeroMapAndDifferentPitches) {
  HeightMap map = test::marker_map(6, 5, 1e-3);
  map.height *= 0;
  const std::string text = codev_int_text(map, kWavelength, "");
  test::expect_same_map(read_text(text), map, 0);
  map.pitch_x = 2.5e-3;
  const HeightMap read =
      read_text(codev_int_text(map, kWavelength, "!no comment"), [](MeasuredSource* s) { s->pitch = 1e-3; });
  EXPECT_NEAR(read.pitch_x, 2.5e-3, 1e-11);
  EXPECT_EQ(read.label, "Map !no comment");
}

TEST(CodeVInt, WriterRefusesWhatTheFormatCannotHold) {
  HeightMap map = test::marker_map(6, 5, 1e-3);
  EXPECT_THROW(codev_int_text(map, 0, "t"), std::invalid_argument);
  map.pitch_x = 0;
  EXPECT_THROW(codev_int_text(map, kWavelength, "t"), std::invalid_argument);
  map.pitch_y = 0;
  EXPECT_NO_THROW(codev_int_text(map, kWavelength, "t"));
  map.height.setConstant(std::nan(""));
  EXPECT_THROW(codev_int_text(map, kWavelength, "t"), std::invalid_argument);
}

TEST(CodeVInt, RefusesWhatIsNoMapOfHeightsAndSaysWhere) {
  const auto refused = [](const std::string& text) { return refusal([&] { read_text(text); }); };
  const std::string head = "t\nGRD 2 1 SUR WVL 1 SSZ 1\n";
  EXPECT_TRUE(contains(refused("t\nZFR 3 SUR WVL 0.001 SSZ 1\n1\n2\n3\n").found(), "Zernike coefficients"));
  EXPECT_TRUE(contains(refused("t\nGRD 2 1 FIL WVL 1 SSZ 1\n1 2\n").found(), "intensity filter"));
  EXPECT_TRUE(contains(refused("t\nGRD 2 1 BIR WVL 1 SSZ 1\n1 2\n").found(), "birefringence"));
  EXPECT_EQ(refused("! c\nt\nGRD 2 1 XYZ WVL 1 SSZ 1\n1 2\n").pointer(), "line 3");
  EXPECT_EQ(refused(head + "1\n").pointer(), "line 3");
  EXPECT_EQ(refused(head + "1 2\n3\n").pointer(), "line 4");
  EXPECT_EQ(refused(head + "1 2.5\n").found(), "'2.5'");
  EXPECT_TRUE(contains(refused("t\nGRD 30000 30000 SUR WVL 1 SSZ 1\n1 2\n").found(), "30000 x 30000"));
  EXPECT_TRUE(contains(refused("t\nGRD 3000000000 3000000000 SUR WVL 1 SSZ 1\n1 2\n").found(), "3000000000"));
  EXPECT_TRUE(contains(refused("t\nGRD -2 -1 SUR WVL 1 SSZ 1\n1 2\n").found(), "-2 x -1"));
  for (const char* header :
       {"GRD 2 1 SUR WVL 0 SSZ 1", "GRD 2 1 SUR WVL 1 SSZ 0", "GRD 2 1 SUR WVL 1", "GRD 2 1",
        "GRD 2 1 SUR WVL 1 SSZ", "GRD 2 1 SUR WVL 1 SSZ 1 NDA 0.5", "GRD 2 1 SUR WVL nan SSZ 1",
        "GRD 2 1 SUR WVL 1 SSZ 1 XSC -1", "GRD 2 1 SUR WVL 1 SSZ 1 ABC 3", "no header"})
    EXPECT_EQ(refused(std::string("t\n") + header + "\n1 2\n").pointer(), "line 2") << header;
  refused("");
  refused("only a title");
}

TEST(CodeVInt, DamagedFilesAreRefusedOrReadNeverACrash) {
  const std::string text = codev_int_text(test::marker_map(7, 8, 1e-3), kWavelength, "damage");
  const auto count = test::read_damaged(text, 60, "int", 1600, [](const std::string& path) {
    MeasuredSource source;
    source.path = path;
    return read_codev_int(source);
  });
  EXPECT_GT(count.refused, 300);
  EXPECT_GT(count.read, 100);
}

}  // namespace
}  // namespace aberfit
