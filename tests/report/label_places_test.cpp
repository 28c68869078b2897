#include "../../src/report/label_places.h"

#include <gtest/gtest.h>

#include <cmath>

namespace aberfit {
using namespace internal;

namespace {

TEST(LabelPlaces, KeepLabelsApartAndOffPointsAndInsideTheFrame) {
  constexpr double kWidth = 400, kHeight = 300;
  LabelPlaces places(kWidth, kHeight);
  const PixelBox point{195, 205, 145, 155};
  places.block(point);
  std::vector<PixelBox> labels;
  // Letters are at least 7 pixels wide and 13 high; this is the box of "65k".
  for (int k = 0; k < 12; ++k) {
    const auto place = places.put(200, 150, 5, "65k");
    if (!place) continue;
    const PixelBox box{place->x - 10, place->x + 10, place->y - 6, place->y + 6};
    EXPECT_FALSE(box.overlaps(point));
    for (const PixelBox& other : labels) EXPECT_FALSE(box.overlaps(other));
    labels.push_back(box);
  }
  EXPECT_GE(labels.size(), 4u);  // four sides
  EXPECT_LE(labels.size(), 8u);  // and then there is no room
  const auto corner = places.put(399, 299, 5, "a long label");
  ASSERT_TRUE(corner.has_value());
  EXPECT_LT(corner->x + 40, kWidth);
  EXPECT_FALSE(LabelPlaces(20, 20).put(10, 10, 5, "no room for this").has_value());
}

TEST(LabelPlaces, GiveWayToAWeakBoxOnlyWhereTheyCan) {
  LabelPlaces places(400, 300);
  places.block({205, 400, 0, 300}, true);
  const auto beside = places.put(200, 150, 5, "x");
  ASSERT_TRUE(beside.has_value());
  EXPECT_LE(beside->x, 200);  // not on the right, the first choice
  LabelPlaces covered(400, 300);
  covered.block({0, 400, 0, 300}, true);
  EXPECT_TRUE(covered.put(200, 150, 5, "x").has_value());
}

}  // namespace
}  // namespace aberfit
