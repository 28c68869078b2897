// Tests clear apertures, masks and eroded rims against independent counts of samples.
#include "aberfit/measured/clear_aperture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <string>

#include "aberfit/core/errors.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using Eigen::Index;

// 41 x 31 points with a pitch of 1 mm, away from the origin; NaN where `valid` is false.
HeightMap map_of(const std::function<bool(double, double)>& valid = {}) {
  HeightMap map;
  map.pitch_x = map.pitch_y = 1e-3;
  map.x0 = 0.1, map.y0 = -0.2;
  map.height = Grid::Constant(31, 41, 1);
  for (Index r = 0; r < 31; ++r)
    for (Index c = 0; c < 41; ++c)
      if (valid && !valid(1e-3 * double(c - 20), 1e-3 * double(r - 15))) map.height(r, c) = std::nan("");
  return map;
}

ClearPart part_of(ClearAperture aperture) {
  ClearPart part;
  part.aperture = std::move(aperture);
  return part;
}

// Expects that exactly the points remain for which `rule` of (x, y) from the middle of the grid [m] is true.
void expect_left(HeightMap map, const ClearPart& part, const std::function<bool(double, double)>& rule,
                 const std::string& mask = "", bool bottom_first = false) {
  Measurement data = map;
  const ClearRegion region = take_clear_part(&data, part, mask, bottom_first);
  Index lost = 0;
  for (Index r = 0; r < 31; ++r)
    for (Index c = 0; c < 41; ++c) {
      const bool was = std::isfinite(map.height(r, c));
      const bool stays = was && rule(1e-3 * double(c - 20), 1e-3 * double(r - 15));
      EXPECT_EQ(std::isfinite(std::get<HeightMap>(data).height(r, c)), stays) << r << " " << c;
      lost += was && !stays;
    }
  EXPECT_EQ(region.taken_out, lost);
  EXPECT_GT(lost, 0);
}

TEST(ClearAperture, LengthsAndPercentagesCutCirclesAnnuliAndRectangles) {
  const auto within = [](double radius) {
    return [=](double x, double y) { return std::hypot(x, y) <= radius * (1 + 1e-6); };
  };
  expect_left(map_of(), part_of({ClearCircle{{24e-3, false}}, {}}), within(12e-3));
  // The circle around all points of a rectangle of 40 x 30 mm has a diameter of 50 mm.
  expect_left(map_of(), part_of({ClearCircle{{60, true}}, {}}), within(15e-3));
  expect_left(map_of(within(13e-3)), part_of({ClearCircle{{50, true}}, {}}), within(6.5e-3));
  expect_left(map_of(), part_of({ClearAnnulus{{40, true}, {20, true}}, {}}), [](double x, double y) {
    return std::hypot(x, y) <= 10e-3 * (1 + 1e-6) && std::hypot(x, y) >= 5e-3 * (1 + 1e-6);
  });
  expect_left(map_of(), part_of({ClearRectangle{{50, true}, {12e-3, false}}, {}}),
              [](double x, double y) { return std::abs(x) <= 10.0001e-3 && std::abs(y) <= 6.0001e-3; });
}

TEST(ClearAperture, IsAboutTheMiddleOfTheValidDataOrMovedFromIt) {
  // Only points right of x = 0 are valid, so the rectangle is about (10 mm, 0).
  const auto right = [](double x, double) { return x >= 0; };
  expect_left(map_of(right), part_of({ClearRectangle{{50, true}, {100, true}}, {}}),
              [](double x, double) { return std::abs(x - 10e-3) <= 5.0001e-3; });
  expect_left(map_of(), part_of({ClearCircle{{10e-3, false}}, {4e-3, -3e-3}}),
              [](double x, double y) { return std::hypot(x - 4e-3, y + 3e-3) <= 5.0001e-3; });
  Measurement data = map_of();
  const ClearRegion region =
      take_clear_part(&data, part_of({ClearCircle{{10e-3, false}}, {4e-3, -3e-3}}), "");
  EXPECT_NEAR(region.x, 0.1 + 20e-3 + 4e-3, 1e-12);
  EXPECT_NEAR(region.y, -0.2 + 15e-3 - 3e-3, 1e-12);
  EXPECT_EQ(region.text(), "circle of 10 mm about (124 mm, -188 mm)");
  const auto outlines = region.outlines();
  ASSERT_EQ(outlines.size(), 1u);
  for (const auto& [x, y] : outlines[0]) EXPECT_NEAR(std::hypot(x - region.x, y - region.y), 5e-3, 1e-12);
}

TEST(ClearAperture, ErodesRimsAndHoles) {
  ClearPart part;
  part.erode = 2;
  expect_left(map_of([](double x, double y) { return std::hypot(x - 5e-3, y) > 0.5e-3; }), part,
              [](double x, double y) {
                return std::abs(x) < 18.5e-3 && std::abs(y) < 13.5e-3 &&
                       std::max(std::abs(x - 5e-3), std::abs(y)) > 2.5e-3;
              });
}

TEST(ClearAperture, TakesAMaskWithItsTopRowFirst) {
  const test::ScratchFolder folder;
  std::string text = "# top row first\n";
  for (int r = 0; r < 31; ++r) {
    for (int c = 0; c < 41; ++c) text += r == 0 ? "0," : c == 3 ? "nan," : "1,";
    text += "\n";
  }
  ClearPart part;
  part.mask = folder.write("mask.csv", text);
  expect_left(
      map_of(), part,
      [](double x, double y) { return y < 14.5e-3 && std::abs(x - 1e-3 * (3 - 20)) > 0.5e-3; }, part.mask);
  // With bottom_first, the first line of the mask is the lowest row.
  expect_left(
      map_of(), part,
      [](double x, double y) { return y > -14.5e-3 && std::abs(x - 1e-3 * (3 - 20)) > 0.5e-3; }, part.mask,
      true);
  Measurement data = map_of();
  for (const std::string bad : {"1 1\n1 1\n", "1 1\n1\n", "1 one\n", ""}) {
    const std::string file = folder.write("bad.csv", bad);
    EXPECT_ANY_THROW(take_clear_part(&data, part, file)) << bad;
  }
  try {
    take_clear_part(&data, part, folder.write("small.csv", "1 1\n1 1\n"));
    ADD_FAILURE();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "the mask has 2 x 2 points, the map 41 x 31");
  }
}

TEST(ClearAperture, OfAProfileIsAnInterval) {
  Profile profile;
  profile.x = Eigen::ArrayXd::LinSpaced(101, 0, 0.1);
  profile.value = Eigen::ArrayXd::Ones(101);
  profile.value.head(20) = std::nan("");
  Measurement data = profile;  // 20 to 100 mm are valid
  ClearPart part = part_of({ClearInterval{{50, true}}, {5e-3}});
  part.erode = 1;
  const ClearRegion region = take_clear_part(&data, part, "");
  const Eigen::ArrayXd& left = std::get<Profile>(data).value;
  for (Index i = 0; i <= 100; ++i) EXPECT_EQ(std::isfinite(left[i]), i > 45 && i < 85) << i;
  EXPECT_EQ(region.taken_out, 81 - 39);
  EXPECT_EQ(region.text(), "interval of 40 mm about 65 mm");
}

TEST(ClearAperture, RefusesWhatDoesNotFit) {
  Profile profile;
  profile.x = Eigen::ArrayXd::LinSpaced(101, 0, 0.1);
  profile.value = Eigen::ArrayXd::Ones(101);
  HeightMap without_pitch = map_of();
  without_pitch.pitch_x = without_pitch.pitch_y = 0;
  ClearPart mask, thick;
  mask.mask = "mask.csv";
  thick.erode = 16;
  const ClearPart circle = part_of({ClearCircle{{50, true}}, {}}), interval = part_of({ClearInterval{}, {}}),
                  away = part_of({ClearCircle{{1e-3, false}}, {0.1, 0}});
  const auto refused = [](Measurement data, const ClearPart& part) {
    try {
      take_clear_part(&data, part, "");
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refused(profile, circle).find("interval"), std::string::npos);
  EXPECT_NE(refused(map_of(), interval).find("circle, annulus or rectangle"), std::string::npos);
  EXPECT_NE(refused(profile, mask).find("a mask is for maps"), std::string::npos);
  EXPECT_NE(refused(without_pitch, circle).find("pitch"), std::string::npos);
  EXPECT_NE(refused(map_of(), away).find("no sample is left"), std::string::npos);
  for (const double times : {1.999, 2.001})  // the circle around all points has a diameter of 50 mm
    EXPECT_EQ(refused(map_of(), part_of({ClearCircle{{times * 50e-3, false}}, {}})).find("more than twice") !=
                  std::string::npos,
              times > 2);
  EXPECT_NE(refused(map_of(), thick).find("no sample is left"), std::string::npos);
}

}  // namespace
}  // namespace aberfit
