#include "aberfit/measured/height_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>
#include <vector>

#include "aberfit/core/random.h"
#include "aberfit/measured/write_map.h"
#include "map_samples.h"

namespace aberfit {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

HeightMap flat(Eigen::Index rows, Eigen::Index columns, double pitch_x, double pitch_y) {
  HeightMap map;
  map.height = Grid::Zero(rows, columns);
  map.pitch_x = pitch_x;
  map.pitch_y = pitch_y;
  centre_on_grid(&map);
  return map;
}

struct Place {
  double x, y;
};
std::vector<Place> valid_places(const HeightMap& map) {
  std::vector<Place> places;
  for (Eigen::Index r = 0; r < map.rows(); ++r)
    for (Eigen::Index c = 0; c < map.columns(); ++c)
      if (std::isfinite(map.height(r, c))) places.push_back({map.x(c), map.y(r)});
  return places;
}

// The smallest circle through two or three of the points that holds them all.
double radius_by_brute_force(const std::vector<Place>& p) {
  constexpr double kRounding = 1e-9;
  double best = p.size() == 1 ? 0 : std::numeric_limits<double>::infinity();
  const auto consider = [&](double x, double y, double radius) {
    if (radius >= best) return;
    for (const Place& q : p)
      if (std::hypot(q.x - x, q.y - y) > radius * (1 + kRounding)) return;
    best = radius;
  };
  for (std::size_t i = 0; i < p.size(); ++i)
    for (std::size_t j = i + 1; j < p.size(); ++j) {
      consider((p[i].x + p[j].x) / 2, (p[i].y + p[j].y) / 2,
               std::hypot(p[i].x - p[j].x, p[i].y - p[j].y) / 2);
      for (std::size_t k = j + 1; k < p.size(); ++k) {
        // Equal distances to the three points, solved by Cramer's rule.
        const double a = 2 * (p[j].x - p[i].x), b = 2 * (p[j].y - p[i].y);
        const double c = 2 * (p[k].x - p[i].x), d = 2 * (p[k].y - p[i].y);
        const double e = p[j].x * p[j].x + p[j].y * p[j].y - p[i].x * p[i].x - p[i].y * p[i].y;
        const double f = p[k].x * p[k].x + p[k].y * p[k].y - p[i].x * p[i].x - p[i].y * p[i].y;
        const double det = a * d - b * c;
        if (std::abs(det) < 1e-12) continue;
        const double x = (e * d - b * f) / det, y = (a * f - e * c) / det;
        consider(x, y, std::hypot(p[i].x - x, p[i].y - y));
      }
    }
  return best;
}

TEST(EnclosingCircle, IsTheSmallestOfAllCirclesThroughPairsAndTriples) {
  const RandomStream stream(1, "enclosing circle");
  std::uint64_t draw = 0;
  for (int trial = 0; trial < 60; ++trial) {
    HeightMap map = flat(3 + trial % 5, 4 + trial % 7, 0.7, 1.3);
    move_origin(&map, -3.25, 8.5);
    for (double& h : map.height.reshaped())
      if (stream.uniform(draw++) < 0.6) h = kNan;
    const std::vector<Place> places = valid_places(map);
    if (places.empty()) continue;
    const Circle circle = enclosing_circle(map);
    EXPECT_NEAR(circle.radius, radius_by_brute_force(places), 1e-9) << trial;
    for (const Place& p : places)
      EXPECT_LE(std::hypot(p.x - circle.x, p.y - circle.y), circle.radius * (1 + 1e-12)) << trial;
  }
}

TEST(EnclosingCircle, OfADiscOfPointsIsTheDisc) {
  HeightMap map = flat(201, 231, 1e-3, 1e-3);
  constexpr double kRadius = 0.085, kX = 0.004, kY = -0.003;
  for (Eigen::Index r = 0; r < map.rows(); ++r)
    for (Eigen::Index c = 0; c < map.columns(); ++c)
      if (std::hypot(map.x(c) - kX, map.y(r) - kY) > kRadius) map.height(r, c) = kNan;
  const Circle circle = enclosing_circle(map);
  // The grid has points on the circle at the four ends of the axes.
  EXPECT_NEAR(circle.x, kX, 1e-9);
  EXPECT_NEAR(circle.y, kY, 1e-9);
  EXPECT_NEAR(circle.radius, kRadius, 1e-9);
}

TEST(EnclosingCircle, HoldsForOnePointALineAndNone) {
  HeightMap map = flat(5, 9, 2, 2);
  map.height.setConstant(kNan);
  EXPECT_EQ(enclosing_circle(map).radius, 0);
  map.height(3, 7) = 1;
  EXPECT_EQ(enclosing_circle(map).x, map.x(7));
  EXPECT_EQ(enclosing_circle(map).y, map.y(3));
  EXPECT_EQ(enclosing_circle(map).radius, 0);
  map.height(3, 1) = map.height(3, 4) = 1;
  EXPECT_NEAR(enclosing_circle(map).radius, 6, 1e-12);
  EXPECT_NEAR(enclosing_circle(map).x, map.x(4), 1e-12);
  map.height(0, 0) = std::numeric_limits<double>::infinity();  // not a measurement either
  EXPECT_NEAR(enclosing_circle(map).radius, 6, 1e-12);
}

TEST(HeightMap, CentresCountsAndMoves) {
  HeightMap map = flat(4, 7, 2, 3);
  EXPECT_EQ(map.x(0), -map.x(6));
  EXPECT_EQ(map.y(0), -map.y(3));
  EXPECT_EQ(map.x(6) - map.x(0), 12);
  map.height(1, 1) = kNan;
  EXPECT_EQ(valid_count(map), 27);
  const double before = map.x(2);
  move_origin(&map, before, 1);
  EXPECT_EQ(map.x(2), 0);
}

TEST(MapCsv, HoldsEveryValidPointToTheLastBit) {
  HeightMap map = test::marker_map(6, 9, 1.25e-3);
  map.label = "two\nlines";  // must not break the comment line
  std::istringstream lines(map_csv(map));
  std::string line;
  std::vector<std::string> data;
  while (std::getline(lines, line))
    if (line[0] != '#') data.push_back(line);
  ASSERT_EQ(data.size(), 52u);
  std::size_t next = 0;
  for (Eigen::Index r = 0; r < map.rows(); ++r)
    for (Eigen::Index c = 0; c < map.columns(); ++c) {
      if (!std::isfinite(map.height(r, c))) continue;
      double x, y, h;
      ASSERT_EQ(std::sscanf(data[next++].c_str(), "%lf,%lf,%lf", &x, &y, &h), 3);
      EXPECT_EQ(x, map.x(c));
      EXPECT_EQ(y, map.y(r));
      EXPECT_EQ(h, map.height(r, c));
    }
  map.pitch_x = 0;
  EXPECT_THROW(map_csv(map), std::invalid_argument);
}

}  // namespace
}  // namespace aberfit
