#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "../../src/spectrum/detrend_basis.h"
#include "aberfit/spectrum/psd_estimate.h"

using namespace aberfit;
using namespace aberfit::internal;

namespace {

// The heights have a rounding of 1e-16, which the quartic of the first ellipse, 1e-5 of the height,
// amplifies. The derivatives of the fit are accurate to 1e-10. The largest observed error is 1e-8.
constexpr double kReached = 1e-7;

struct Ellipse {
  double p, q, theta, half_length;
};

// Height over the tangent at the pole, from |P - F1| + |P - F2| = p + q alone, by Newton's method in extended
// precision. Its rounding of 1e-19 (p + q) / (2 sin theta) is far below a picometre.
double height_at(const Ellipse& e, double along) {
  using Real = long double;
  const Real c = std::cos(Real(e.theta)), s = std::sin(Real(e.theta)), x = along;
  Real z = 0;
  for (int step = 0; step < 50; ++step) {
    const Real d1 = std::hypot(x + e.p * c, z - e.p * s), d2 = std::hypot(x - e.q * c, z - e.q * s);
    z -= (d1 + d2 - (Real(e.p) + Real(e.q))) / ((z - e.p * s) / d1 + (z - e.q * s) / d2);
  }
  return double(z);
}

Profile profile_of(const Ellipse& e, double sign) {
  Profile profile;
  profile.x = Eigen::ArrayXd::LinSpaced(401, 0.02, 0.02 + 2 * e.half_length);  // the pole is in the middle
  profile.value = profile.x.unaryExpr([&](double x) { return height_at(e, x - 0.02 - e.half_length); });
  profile.value = sign * profile.value + 2e-6 + 3e-5 * profile.x;
  return profile;
}

Profile slopes_of(const Profile& heights, const Ellipse& e, double sign) {
  Profile slopes = heights;
  slopes.quantity = ProfileQuantity::kSlope;
  for (Eigen::Index i = 0; i < slopes.size(); ++i) {
    // The normal bisects the angle between the rays to the foci: z' = -(e1 + e2)_x / (e1 + e2)_z.
    const double x = slopes.x[i] - 0.02 - e.half_length, z = height_at(e, x);
    const double c = std::cos(e.theta), s = std::sin(e.theta);
    const double d1 = std::hypot(x + e.p * c, z - e.p * s), d2 = std::hypot(x - e.q * c, z - e.q * s);
    slopes.value[i] =
        sign * -((x + e.p * c) / d1 + (x - e.q * c) / d2) / ((z - e.p * s) / d1 + (z - e.q * s) / d2) + 3e-5;
  }
  return slopes;
}

}  // namespace

TEST(DetrendEllipse, ArmsAndAngleOfASyntheticEllipseAreRecovered) {
  // A synchrotron focuser, a short one upstream, a steep mirror. The longer arm matters through 1/p only.
  for (const Ellipse& e : {Ellipse{30, 0.4, 3e-3, 0.1}, Ellipse{2, 5, 2e-2, 0.15}, Ellipse{1, 0.5, 0.3, 0.1}})
    for (const double sign : {1., -1.}) {
      const Profile heights = profile_of(e, sign);
      for (const Profile& profile : {heights, slopes_of(heights, e, sign)}) {
        const EllipseFit fit = fit_ellipse(profile);
        ASSERT_TRUE(fit.converged);
        const std::string name = std::to_string(e.p) +
                                 (profile.quantity == ProfileQuantity::kSlope ? " slope " : " height ") +
                                 std::to_string(sign);
        // The sign of the cubic determines which arm is which.
        EXPECT_NEAR(fit.p / e.p, 1, kReached) << name;
        EXPECT_NEAR(fit.q / e.q, 1, kReached) << name;
        EXPECT_NEAR(fit.grazing_angle / e.theta, 1, kReached) << name;
        const double scale = rms(detrend(profile, {DetrendShape::kPolynomial, 1}));
        EXPECT_LT(rms(detrend(profile, {DetrendShape::kEllipse, 2})), 1e-9 * scale) << name;
      }
    }
}

TEST(DetrendEllipse, PoleIsTheMiddleOfTheValidSamples) {
  const Ellipse e{2, 5, 2e-2, 0.15};
  Profile profile = profile_of(e, 1);
  profile.value[200] = profile.value[37] = std::numeric_limits<double>::quiet_NaN();
  const EllipseFit fit = fit_ellipse(profile);
  ASSERT_TRUE(fit.converged);
  EXPECT_NEAR(fit.p / e.p, 1, kReached);
  EXPECT_TRUE(fit.shape.isFinite().all());
}

// For plane waves onto the mirror: x cos(theta) - z sin(theta) + |P - F2| = q.
TEST(DetrendEllipse, AParabolaIsAnEllipseWithOneArmFarAway) {
  constexpr double kArm = 3, kTheta = 1e-2, kHalf = 0.1;
  Profile profile;
  profile.x = Eigen::ArrayXd::LinSpaced(401, -kHalf, kHalf);
  profile.value = profile.x.unaryExpr([&](double along) {
    using Real = long double;
    const Real c = std::cos(Real(kTheta)), s = std::sin(Real(kTheta)), x = along;
    Real z = 0;
    for (int step = 0; step < 50; ++step) {
      const Real d = std::hypot(x - kArm * c, z - kArm * s);
      z -= (x * c - z * s + d - kArm) / ((z - kArm * s) / d - s);
    }
    return double(z);
  });
  const EllipseFit fit = fit_ellipse(profile);
  ASSERT_TRUE(fit.converged);
  EXPECT_GT(fit.p, 1e4);
  EXPECT_NEAR(fit.q / kArm, 1, 1e-5);
  EXPECT_NEAR(fit.grazing_angle / kTheta, 1, 1e-5);
  EXPECT_LT((fit.shape - profile.value).abs().maxCoeff(), 1e-9 * profile.value.abs().maxCoeff());
}

TEST(DetrendEllipse, APlaneHasNoneAndSaysThatAParabolaWasTakenOff) {
  Profile plane;
  plane.x = Eigen::ArrayXd::LinSpaced(64, 0, 0.063);
  plane.value = 1e-6 + 3e-5 * plane.x;
  EXPECT_FALSE(fit_ellipse(plane).converged);
  PsdEstimatorOptions options;
  options.detrend = {DetrendShape::kEllipse, 6};
  const PsdEstimate estimate = estimate_psd(plane, options);
  ASSERT_EQ(estimate.warnings.size(), 1u);
  EXPECT_EQ(estimate.warnings[0].code, "ellipse-fit-failed");
  options.detrend = {DetrendShape::kPolynomial, 2};
  const PsdEstimate parabola = estimate_psd(plane, options);
  EXPECT_TRUE(parabola.warnings.empty());
  EXPECT_EQ(estimate.rms_height, parabola.rms_height);
  EXPECT_TRUE((estimate.psd == parabola.psd).all());
  EXPECT_EQ(estimate.response, parabola.response);  // the response of the parabola, which was subtracted
  EXPECT_EQ(estimate.options.detrend.shape, DetrendShape::kPolynomial);
}
