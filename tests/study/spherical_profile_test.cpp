#include "spherical_profile.h"

#include <gtest/gtest.h>

#include "aberfit/commands/run.h"
#include "aberfit/study/read_study.h"

using namespace aberfit;

namespace {

Study spherical_study() { return read_study(ABERFIT_SOURCE_DIR "/fits/spherical/study.json"); }

bool warns_of_overlap(const ResultDocument& result) {
  for (const Warning& warning : result.warnings)
    if (warning.code == "m0-overlap") return true;
  return false;
}

}  // namespace

TEST(SphericalStudy, ProfileIsThatOfTheStatedMirror) {
  const Study study = spherical_study();
  const StatisticRequest& request = study.target.statistics.at(0);
  const test::SphericalMirror mirror;
  ASSERT_EQ(request.profile_dz.size(), std::size_t(2 * mirror.half_planes + 1));
  for (std::size_t k = 0; k < request.profile_dz.size(); ++k)
    EXPECT_NEAR(request.profile_value[k], test::ring_share(mirror, request.profile_dz[k]), 1e-8)
        << request.profile_dz[k];
}

TEST(SphericalStudy, FittedMirrorHasTheProfileByTheOtherMethod) {
  const ResultDocument result = run_fit(spherical_study(), {});
  ASSERT_EQ(result.fitted.fit.status, FitStatus::kConverged) << result.fitted.fit.message;
  test::SphericalMirror fitted;
  for (std::size_t k = 0; k < 5; ++k) fitted.rim_height[k] = result.fitted.fit.coefficients[Eigen::Index(k)];
  const test::SphericalMirror truth;
  for (int k = -truth.half_planes; k <= truth.half_planes; ++k)
    EXPECT_NEAR(test::ring_share(fitted, k * truth.step), test::ring_share(truth, k * truth.step), 5e-4) << k;
  EXPECT_FALSE(warns_of_overlap(result));
}

TEST(SphericalStudy, SaysWhenZernikesAndPowersOverlap) {
  // Z_2^0, Z_4^0, Z_6^0, rho^4 and rho^6: the slopes of these five terms span three dimensions.
  Study study = spherical_study();
  study.terms.spherical = {4, 6};
  study.terms.zernike = ZernikeSpec{2, 6};
  study.fit.starts = 1;
  study.fit.max_iterations = 3;
  EXPECT_TRUE(warns_of_overlap(run_fit(study, {})));
}
