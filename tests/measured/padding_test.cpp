// Tests which heights are padding: one exact value of many points that rounding does not explain.
#include "aberfit/measured/padding.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "aberfit/measured/read_measurement.h"
#include "mutation.h"
#include "synthetic_files.h"

namespace aberfit::test {
namespace {

constexpr int kSide = 96;

// Positions are from -1 to 1 along both axes.
HeightMap map_of(const std::function<double(double, double)>& height) {
  HeightMap map;
  map.height.resize(kSide, kSide);
  map.pitch_x = map.pitch_y = 2.0 / (kSide - 1);
  map.x0 = map.y0 = -1;
  for (Eigen::Index r = 0; r < kSide; ++r)
    for (Eigen::Index c = 0; c < kSide; ++c) map.height(r, c) = height(map.x(c), map.y(r));
  return map;
}

bool in_disc(double x, double y) { return std::hypot(x, y) < 0.9; }

TEST(Padding, OutsideAPupilIsFoundWithItsPlace) {
  Draws draws(1);
  for (const double value : {0.0, -9999e-9, 3.4e38, 1.25e-7}) {
    Eigen::Index outside = 0;
    const HeightMap map = map_of([&](double x, double y) {
      const double h = 5e-9 * draws.normal() + 1e-7 * (x * x + y * y);
      outside += !in_disc(x, y);
      return in_disc(x, y) ? h : value;
    });
    const std::vector<Padding> found = find_padding(map);
    ASSERT_EQ(found.size(), 1u) << value;
    EXPECT_EQ(found[0].height, value);
    EXPECT_EQ(found[0].points, outside);
    EXPECT_EQ(found[0].outside, outside);  // a disc is convex, so its hull holds no point outside it
    EXPECT_EQ(found[0].blocks, 1);         // the disc leaves a frame around it
    EXPECT_EQ(padded_points(map, found).count(), outside);
  }
}

TEST(Padding, OfTwoValuesIsFoundWithBoth) {
  Draws draws(2);
  const HeightMap map = map_of([&](double x, double y) {
    if (!in_disc(x, y)) return -9999e-9;
    return std::hypot(x, y) < 0.3 ? 0.0 : 20e-9 + 4e-9 * draws.normal() + 3e-8 * x;
  });
  const std::vector<Padding> found = find_padding(map);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].height, -9999e-9);
  EXPECT_EQ(found[1].height, 0);
  EXPECT_EQ(found[0].outside, found[0].points);
  EXPECT_EQ(found[1].outside, 0);  // the hole of an annulus
  EXPECT_EQ(found[1].blocks, 1);
}

TEST(Padding, OfScatteredDropoutsIsFoundToo) {
  Draws draws(3);
  Eigen::Index dropped = 0;
  const HeightMap map = map_of([&](double x, double y) {
    const bool lost = draws.uniform() < 0.03;
    const double h = 8e-9 * draws.normal() + 1e-7 * x * y;
    dropped += lost;
    return lost ? 0 : h;
  });
  const std::vector<Padding> found = find_padding(map);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].points, dropped);
  EXPECT_GT(found[0].blocks, 0.8 * double(dropped));
}

// The padding is 0, and heights inside the pupil are integers that include 0.
TEST(Padding, IsFoundAmongRoundedHeights) {
  for (const double step : {1e-10, 1e-9, 3e-9}) {
    Draws draws(4);
    const HeightMap map = map_of([&](double x, double y) {
      const double h = step * std::round((6e-9 * draws.normal() + 2e-8 * y) / step);
      return in_disc(x, y) ? h : 0;
    });
    const std::vector<Padding> found = find_padding(map);
    ASSERT_EQ(found.size(), 1u) << step;
    EXPECT_EQ(found[0].height, 0);
  }
}

TEST(Padding, RoundedHeightsAreNone) {
  using Surface = std::function<double(double, double)>;
  Draws draws(5);
  const std::vector<std::pair<std::string, Surface>> surfaces = {
      {"white noise", [&](double, double) { return 0.12 * draws.normal(); }},
      {"plane", [](double x, double) { return x; }},
      {"slanted plane", [](double x, double y) { return 0.7 * x + 0.3 * y; }},
      {"paraboloid", [](double x, double y) { return x * x + y * y - 0.7; }},
      {"sphere with noise", [&](double x, double y) { return x * x + y * y + 0.02 * draws.normal(); }},
      {"cubic cylinder", [](double x, double) { return x * x * x; }},
      {"fourth order", [](double x, double y) { return std::pow(x * x + y * y, 2); }},
      {"saddle", [](double x, double y) { return x * x - y * y; }},
      {"bump on a level surface", [](double x, double y) { return std::exp(-20 * (x * x + y * y)); }},
      {"waves", [](double x, double y) { return std::sin(9 * x) * std::cos(7 * y); }},
      {"terraces of a mirror with an edge", [](double x, double) { return std::max(0.0, x - 0.4); }},
  };
  // Resolutions from 8 bits over the range down to a few levels.
  for (const auto& [name, surface] : surfaces)
    for (const double levels : {128.0, 64.0, 20.0, 8.0, 3.0})
      for (const bool disc : {false, true}) {
        const HeightMap map = map_of([&](double x, double y) {
          return disc && !in_disc(x, y) ? std::nan("") : 1e-9 * std::round(levels * surface(x, y));
        });
        const std::vector<Padding> found = find_padding(map);
        EXPECT_TRUE(found.empty()) << name << ", " << levels << " levels: " << found[0].points << " of "
                                   << found[0].height;
      }
}

// Exact zeros of computed surfaces: along axes, diagonals and a middle row.
TEST(Padding, LinesThatASurfaceCrossesAreNone) {
  const std::vector<std::function<double(double, double)>> surfaces = {
      [](double x, double y) { return x * y; }, [](double x, double y) { return x * x - y * y; },
      [](double x, double y) { return y * (3 * (x * x + y * y) - 2); },
      [](double x, double y) { return std::sin(6 * x) * std::sin(6 * y); },
      [](double, double y) { return y * y * y; }};
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    HeightMap map;
    map.height.resize(65, 65);  // odd, so that one row and one column are on the axes
    map.pitch_x = map.pitch_y = 1.0 / 32;
    map.x0 = map.y0 = -1;
    for (Eigen::Index r = 0; r < 65; ++r)
      for (Eigen::Index c = 0; c < 65; ++c) map.height(r, c) = 1e-7 * surfaces[i](map.x(c), map.y(r));
    EXPECT_TRUE(find_padding(map).empty()) << i;
  }
}

TEST(Padding, OfContinuousHeightsAConstantMapOrAnEmptyOneThereIsNone) {
  Draws draws(6);
  EXPECT_TRUE(find_padding(map_of([&](double, double) { return draws.normal(); })).empty());
  EXPECT_TRUE(find_padding(map_of([](double, double) { return 0.0; })).empty());
  EXPECT_TRUE(find_padding(map_of([](double, double) { return std::nan(""); })).empty());
}

// `invalid` has the values of the file, whatever its unit and whether it is of a wavefront.
TEST(InvalidValues, AreHolesInTheUnitOfTheFile) {
  const Scratch scratch;
  for (const std::string of : {"surface", "wavefront"})
    for (const std::string unit : {"nm", "um", "m"}) {
      MeasuredSource source;
      source.path = scratch.write("a.txt", "# of: " + of + "\n# pitch = 1 mm\n# unit: " + unit +
                                               "\n0 1e-3 -9999 3.4028235e38\n0.0 0.002 -9999.0 1e-9\n");
      source.invalid = {0, -9999, 3.40282347e38};
      const HeightMap map = std::get<HeightMap>(read_measurement(source));
      EXPECT_EQ(map.said_invalid, 5) << of << unit;
      EXPECT_EQ(valid_count(map), 3);
      EXPECT_TRUE(std::isfinite(map.height(0, 3)));
    }
}

TEST(InvalidValues, OfProfilesAreThoseOfTheChosenScanLine) {
  const Scratch scratch;
  MeasuredSource source;
  source.path = scratch.write("a.csv", "x_mm,slope_urad,height_nm\n0,1,-1\n1,-1,5\n2,0,-1\n3,2,7\n");
  source.invalid = {-1};
  EXPECT_EQ(std::get<Profile>(read_measurement(source)).said_invalid, 1);
  source.column = 2;
  const Profile heights = std::get<Profile>(read_measurement(source));
  EXPECT_EQ(heights.said_invalid, 2);
  EXPECT_TRUE(std::isnan(heights.value[0]) && std::isnan(heights.value[2]));
  source.invalid = {12};
  EXPECT_EQ(std::get<Profile>(read_measurement(source)).said_invalid, 0);
}

TEST(InvalidValues, AreNamedWhereNoMirrorIsSoHigh) {
  const Scratch scratch;
  MeasuredSource source;
  source.path = scratch.write(
      "a.txt", "# of: surface\n# pitch = 1 mm\n# unit: nm\n1 2 3.4028235e38\n4 5 3.4028235e38\n");
  const std::string told = input_error([&] { read_measurement(source); });
  EXPECT_NE(told.find("2 points, all 3.4028235e+38 in the file"), std::string::npos) << told;
  EXPECT_NE(told.find("option 'invalid'"), std::string::npos) << told;
}

}  // namespace
}  // namespace aberfit::test
