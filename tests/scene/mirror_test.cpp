// Tests the largest radius of a conic sag: that of a sphere, or where the root becomes imaginary.
#include "aberfit/scene/mirror.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace aberfit;

TEST(SagDomain, OfASphereEndsAtItsRadiusOfCurvature) {
  EXPECT_DOUBLE_EQ(sag_domain_radius(Mirror{.focal_length = 0.15, .conic = 0}), 0.3);
}

TEST(SagDomain, EndsWhereTheSagDoes) {
  for (const double conic : {0.7, 0.0, -0.4, -0.99}) {
    const Mirror mirror{.focal_length = 2.8, .conic = conic};
    const double end = sag_domain_radius(mirror);
    EXPECT_TRUE(std::isfinite(base_surface(mirror, end * (1 - 1e-9), 0.0).height)) << conic;
    EXPECT_TRUE(std::isnan(base_surface(mirror, end * (1 + 1e-9), 0.0).height)) << conic;
    // At this radius the height of an ellipsoid is its half axis 2 f/(1 + k).
    EXPECT_NEAR(base_surface(mirror, end * (1 - 1e-12), 0.0).height / (2 * 2.8 / (1 + conic)), 1, 1e-5)
        << conic;
  }
  for (const double conic : {-1.0, -2.5})
    EXPECT_TRUE(std::isinf(sag_domain_radius(Mirror{.focal_length = 2.8, .conic = conic}))) << conic;
}
