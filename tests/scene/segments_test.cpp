// Tests which segment holds a point, and the grid cells and terms of segments.
#include "aberfit/scene/segments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace aberfit {
namespace {

SegmentedAperture flower() {
  SegmentedAperture result = hexagonal_segments(1, 0.2, 0.01, true, 0.1);
  result.piston = 2e-8;
  result.tip_tilt = 3e-8;
  return result;
}

TEST(Segments, OfHexagonsHaveTheirMiddleAndTheirCorners) {
  const Segments segments(flower());
  ASSERT_EQ(segments.all().size(), 7u);
  for (std::size_t k = 0; k < 7; ++k) {
    const Segments::Segment& one = segments.all()[k];
    EXPECT_NEAR(one.radius, 0.2 / std::numbers::sqrt3, 1e-12);
    EXPECT_EQ(segments.at(one.centre[0] + 0.05, one.centre[1] - 0.06), k);
    EXPECT_NEAR(segments.variance(k, one.centre[0], one.centre[1] + 0.1), 4e-16 + 9e-16 * 0.01, 1e-22);
  }
}

// The points are 1 mm from one segment and 9 mm from the other.
TEST(Segments, TakeWhatLiesInAGapToTheNearestEdge) {
  const SegmentedAperture two{{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {{1.01, 0}, {2, 0}, {2, 1}, {1.01, 1}}}, 0};
  const Segments segments(two);
  EXPECT_EQ(segments.at(1.001, 0.3), 0u);
  EXPECT_EQ(segments.at(1.009, 0.3), 1u);
  EXPECT_EQ(segments.at(5, 0.3), 1u);
}

// The common part of two crossing vanes has an outline of its own, which is not a segment.
TEST(Segments, AreNotWhatVanesCover) {
  const SegmentedAperture crossed = obstructed(flower(), {{0.01, 0, 0}, {0.01, 0.3, 0}, {0.01, 2, 0.002}});
  EXPECT_EQ(crossed.piston, 2e-8);
  const Segments segments(crossed);
  ASSERT_EQ(segments.all().size(), 7u);
  std::size_t outlines = 0;
  double area = 0;
  for (const Segments::Segment& one : segments.all()) {
    outlines += one.clear.size();
    area += aperture_area(SegmentedAperture{one.clear});
  }
  EXPECT_EQ(outlines, crossed.outlines.size());
  EXPECT_NEAR(area, aperture_area(crossed), 1e-15);
}

TEST(Segments, ErrWhereTheirApertureSaysSo) {
  EXPECT_TRUE(has_segment_errors(flower()));
  EXPECT_FALSE(has_segment_errors(without_segment_errors(flower())));
  EXPECT_FALSE(has_segment_errors(CircleAperture{1}));
}

}  // namespace
}  // namespace aberfit
