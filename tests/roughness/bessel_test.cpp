#include "aberfit/roughness/bessel.h"

#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>

using namespace aberfit;

TEST(Bessel, AgreesWithTheLibraryOnEveryInstructionSet) {
  constexpr double kAbsolute = 6e-15, kRounding = 2e-16;  // from the header; largest error 5.4e-15
  for (const InstructionSet set :
       {InstructionSet::kBaseline, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (!is_supported(set)) continue;
    for (double z = 1e-9; z < 3e4; z *= 1.013) {
      double j0, j1;
      bessel_j0_j1(&z, 1, &j0, &j1, set);
      const double one = 1, rest = one_minus_j0_sum(z, &one, &one, 1, set);
      const double tolerance = kAbsolute + kRounding * std::sqrt(z);
      EXPECT_NEAR(j0, boost::math::cyl_bessel_j(0, z), tolerance) << z;
      EXPECT_NEAR(j1, boost::math::cyl_bessel_j(1, z), tolerance) << z;
      const double q = 0.25 * z * z, series = q - q * q / 4 + q * q * q / 36 - q * q * q * q / 576;
      EXPECT_NEAR(rest / (z < 0.05 ? series : 1 - boost::math::cyl_bessel_j(0, z)), 1, 4e-13) << z;
    }
  }
}
