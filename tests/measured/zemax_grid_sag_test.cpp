#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>

#include "aberfit/measured/read_measurement.h"
#include "aberfit/measured/write_map.h"
#include "map_mutation.h"
#include "map_samples.h"

namespace aberfit {
namespace {

using test::contains;
using test::refusal;
using test::ScratchFolder;

GridSag read_text(const std::string& text) {
  const ScratchFolder folder;
  return read_zemax_grid_sag_with_derivatives(folder.write("a.dat", text));
}

// 5 x 5 lines of z = 1, 2, ... with slopes 0.01, 0.02 and twist 0.5.
std::string small_file(int unit, const std::string& header = "") {
  std::string text = header.empty() ? "5 5 2 3 " + std::to_string(unit) + " 0 0\n" : header;
  for (int i = 1; i <= 25; ++i) text += std::to_string(i) + " 0.01 0.02 0.5\n";
  return text;
}

// Heights, slopes and twist of a smooth surface without symmetry, with two holes and the bump of the marker.
GridSag wavy(Eigen::Index rows, Eigen::Index columns, double offset) {
  GridSag sag;
  sag.map = test::marker_map(rows, columns, 1.5e-3, offset);
  sag.map.pitch_y = 2.5e-3;
  centre_on_grid(&sag.map);
  move_origin(&sag.map, -4e-3, 7e-3);
  sag.dx = sag.dy = sag.dxdy = sag.map.height;
  for (Eigen::Index r = 0; r < rows; ++r)
    for (Eigen::Index c = 0; c < columns; ++c) {
      sag.dx(r, c) = 1e-6 * double(3 * c - r);
      sag.dy(r, c) = -2e-6 * double(c + 5 * r);
      sag.dxdy(r, c) = 1e-3 * double(r * c + 1);
    }
  return sag;
}

void expect_near(double found, double expected) { EXPECT_NEAR(found, expected, 1e-11 * std::abs(expected)); }

TEST(ZemaxGridSag, FirstLineIsTheUpperLeftCornerAndRunsAlongX) {
  std::string text = "6 5 1 1 0 0 0\n";
  for (int i = 0; i < 30; ++i) text += std::to_string(i) + " 0 0 0\n";
  const HeightMap map = read_text(text).map;
  ASSERT_EQ(map.columns(), 6);
  ASSERT_EQ(map.rows(), 5);
  EXPECT_EQ(map.height(4, 0), 0);  // (-x, +y)
  expect_near(map.height(4, 5), 5e-3);
  expect_near(map.height(0, 0), 24e-3);
  EXPECT_EQ(map.x(0), -map.x(5));
  EXPECT_EQ(map.y(0), -map.y(4));
}

TEST(ZemaxGridSag, UnitScalesHeightSpacingAndTwistButNotSlopes) {
  const double metres[] = {1e-3, 1e-2, 0.0254, 1};
  for (int unit = 0; unit < 4; ++unit) {
    const GridSag sag = read_text(small_file(unit));
    expect_near(sag.map.pitch_x, 2 * metres[unit]);
    expect_near(sag.map.pitch_y, 3 * metres[unit]);
    expect_near(sag.map.height(4, 1), 2 * metres[unit]);
    EXPECT_EQ(sag.dx(2, 2), 0.01);
    EXPECT_EQ(sag.dy(2, 2), 0.02);
    expect_near(sag.dxdy(2, 2), 0.5 / metres[unit]);
  }
}

TEST(ZemaxGridSag, ReadsCommentsDecentreAndNoData) {
  std::string text = "! a comment\r\n\r\n5 5 2 3 0 10 -20\r\n! another\r\n";
  for (int i = 0; i < 25; ++i)
    text += std::to_string(i) + " +1e-2 2E-2 0.5" +
            (i == 3   ? " 1"
             : i == 4 ? " -7"
             : i % 2  ? " 0"
                      : "") +
            "\r\n";
  const GridSag sag = read_text(text);
  EXPECT_TRUE(std::isnan(sag.map.height(4, 3)));
  EXPECT_TRUE(std::isnan(sag.map.height(4, 4)));
  EXPECT_TRUE(std::isnan(sag.dx(4, 3)));
  EXPECT_EQ(valid_count(sag.map), 23);
  EXPECT_NEAR(sag.map.x(2), 10e-3, 1e-15);
  EXPECT_NEAR(sag.map.y(2), -20e-3, 1e-15);
}

TEST(ZemaxGridSag, OptionsMayNotContradictTheFile) {
  const ScratchFolder folder;
  MeasuredSource source;
  source.path = folder.write("a.dat", small_file(0, "5 5 2 3 0 10 -20\n"));
  expect_near(read_zemax_grid_sag(source).height(4, 1), 2e-3);
  source.wavefront = true;
  EXPECT_EQ(refusal([&] { read_zemax_grid_sag(source); }).pointer(), "option 'of'");
  source.wavefront = false;
  EXPECT_EQ(read_zemax_grid_sag(source).rows(), 5);
  source.pitch = 4e-3;
  EXPECT_EQ(refusal([&] { read_zemax_grid_sag(source); }).pointer(), "option 'pitch'");
}

TEST(ZemaxGridSag, RoundTripsThroughBothReaders) {
  for (const double offset : {0.0, 1e-6, -1e-6})
    for (const auto& [rows, columns] : {std::pair{5, 9}, std::pair{12, 7}}) {
      const GridSag sag = wavy(rows, columns, offset);
      const std::string text = zemax_grid_sag_text(sag, "two\nlines");
      const double rounding = 1e-11;  // 13 digits are written
      const GridSag own = read_text(text);
      test::expect_same_map(own.map, sag.map, rounding * 2e-6);
      expect_near(own.map.pitch_x, sag.map.pitch_x);
      expect_near(own.map.pitch_y, sag.map.pitch_y);
      expect_near(own.map.x0, sag.map.x0);
      expect_near(own.map.y0, sag.map.y0);
      // An independent reading in millimetres, line by line.
      std::istringstream in(text);
      std::string comment;
      std::getline(in, comment);
      EXPECT_EQ(comment, "! two lines");
      double nx, ny, delx, dely, unit, xdec, ydec;
      in >> nx >> ny >> delx >> dely >> unit >> xdec >> ydec;
      EXPECT_EQ(nx, columns);
      EXPECT_EQ(ny, rows);
      EXPECT_EQ(unit, 0);
      expect_near(delx, 1.5);
      expect_near(dely, 2.5);
      expect_near(xdec, 4);
      expect_near(ydec, -7);
      for (Eigen::Index r = rows - 1; r >= 0; --r)
        for (Eigen::Index c = 0; c < columns; ++c) {
          double z, dx, dy, dxdy;
          int no_data;
          ASSERT_TRUE(bool(in >> z >> dx >> dy >> dxdy >> no_data));
          const bool valid = std::isfinite(sag.map.height(r, c));
          ASSERT_EQ(no_data, valid ? 0 : 1);
          if (!valid) continue;
          expect_near(z, sag.map.height(r, c) * 1e3);
          expect_near(dx, sag.dx(r, c));
          expect_near(dy, sag.dy(r, c));
          expect_near(dxdy, sag.dxdy(r, c) * 1e-3);
          expect_near(own.dx(r, c), sag.dx(r, c));
          expect_near(own.dy(r, c), sag.dy(r, c));
          expect_near(own.dxdy(r, c), sag.dxdy(r, c));
        }
    }
}

TEST(ZemaxGridSag, WriterRefusesWhatTheFormatCannotHold) {
  const GridSag good = wavy(6, 7, 0);
  GridSag sag = good;
  sag.dxdy.resize(7, 6);
  EXPECT_THROW(zemax_grid_sag_text(sag, ""), std::invalid_argument);
  sag = good;
  sag.map.pitch_y = 0;
  EXPECT_THROW(zemax_grid_sag_text(sag, ""), std::invalid_argument);
  sag = good;
  sag.dy(3, 3) = std::nan("");
  EXPECT_THROW(zemax_grid_sag_text(sag, ""), std::invalid_argument);
  EXPECT_THROW(zemax_grid_sag_text(wavy(4, 7, 0), ""), std::invalid_argument);
}

TEST(ZemaxGridSag, RefusesDamageAndSaysWhere) {
  const auto refused = [](const std::string& text) { return refusal([&] { read_text(text); }); };
  for (const char* header : {"4 5 1 1 0 0 0\n", "5 5 0 1 0 0 0\n", "5 5 1 -1 0 0 0\n", "5 5 1 1 4 0 0\n",
                             "5 5 1 1 0 0\n", "5.5 5 1 1 0 0 0\n", "5 5 1 1 0 nan 0\n", "-5 -5 1 1 0 0 0\n",
                             "5 5 1 1 0 0 0 0\n", "5 5 1 1e999 0 0 0\n"})
    EXPECT_EQ(refused(small_file(0, header)).pointer(), "line 1") << header;
  EXPECT_TRUE(contains(refused(small_file(0, "9000000000 9000000000 1 1 0 0 0\n")).found(), "9000000000"));
  EXPECT_TRUE(contains(refused(small_file(0, "30000 30000 1 1 0 0 0\n")).found(), "30000 x 30000"));
  EXPECT_TRUE(contains(refused(small_file(0, "5 6 1 1 0 0 0\n")).found(), "after 25 points"));
  EXPECT_EQ(refused(small_file(0) + "1 0 0 0\n").pointer(), "line 27");
  EXPECT_EQ(refused(small_file(0) + "1 0 0\n").pointer(), "line 27");
  std::string text = small_file(0);
  text.replace(text.find("0.01"), 4, "abcd");
  EXPECT_EQ(refused(text).pointer(), "line 2");
  EXPECT_EQ(refused(text).found(), "'abcd'");
  refused("");
  refused("!\n\n");
}

TEST(ZemaxGridSag, DamagedFilesAreRefusedOrReadNeverACrash) {
  const std::string text = zemax_grid_sag_text(wavy(6, 7, 0), "damage");
  const auto count = test::read_damaged(text, 60, "grid sag", 1400, [](const std::string& path) {
    MeasuredSource source;
    source.path = path;
    return read_zemax_grid_sag(source);
  });
  EXPECT_GT(count.refused, 300);
  EXPECT_GT(count.read, 100);
}

}  // namespace
}  // namespace aberfit
