#include "aberfit/theory/halo_kernel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/core/constants.h"

namespace aberfit {
namespace {

constexpr double kWavelength = 1e-6;

// A smooth mirror with roughness of one density between two frequencies: to first order, the BSDF is constant
// between two rings and zero elsewhere.
const ScatterFunction& two_rings() {
  static const ScatterFunction scatter(RadialPsd(UniformPsd{1e-12, 100, 200}), kWavelength);
  return scatter;
}

TEST(HaloKernel, OfTwoRingsIsTheAreaOfAPixelBetweenThem) {
  const double pixel = 1e-5;  // the rings are at 10 and 20 pixels
  const HaloKernel kernel = halo_kernel(two_rings(), pixel, 51);
  const double bsdf = two_rings().bsdf(15 * pixel), whole = bsdf * pixel * pixel;
  EXPECT_NEAR(kernel.fraction(25, 40) / whole, 1, 1e-7);
  EXPECT_NEAR(kernel.fraction(25, 25) / whole, 0, 1e-7);
  EXPECT_NEAR(kernel.fraction(0, 0) / whole, 0, 1e-7);
  // The pixel at x = 10, y = 0: the inner ring cuts it. Its part outside, by integrating over y.
  double outside = 0;
  for (int k = 0; k < 1000; ++k) {
    const double y = (k + 0.5) / 1000 - 0.5;
    outside += (10.5 - std::sqrt(100 - y * y)) / 1000;
  }
  EXPECT_NEAR(kernel.fraction(25, 35) / whole, outside, 1e-6);
  EXPECT_NEAR(kernel.halo / two_rings().tis(), 1, 1e-7);
  EXPECT_NEAR(kernel.core + kernel.halo + kernel.beyond, 1, 1e-15);
}

TEST(HaloKernel, HasTheSameEnergyOnFinerPixels) {
  const ScatterFunction scatter(RadialPsd(KCorrelationPsd{60e-9, 0.02, 2.6, 2, 5000}), kWavelength);
  for (const int fine : {2, 3}) {
    const HaloKernel coarse = halo_kernel(scatter, 6e-5, 24),
                     finer = halo_kernel(scatter, 6e-5 / fine, 24 * fine);
    EXPECT_NEAR(coarse.halo, finer.halo, 1e-9);
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 24; ++x)
        EXPECT_NEAR(coarse.fraction(y, x), finer.fraction.block(y * fine, x * fine, fine, fine).sum(), 1e-9)
            << y << " " << x;
  }
}

TEST(HaloKernel, RefusesWhatHasNoPixels) {
  EXPECT_THROW(halo_kernel(two_rings(), 0, 5), std::invalid_argument);
  EXPECT_THROW(halo_kernel(two_rings(), 1e-5, 0), std::invalid_argument);
  const ScatterFunction nothing(RadialPsd(UniformPsd{1e-9, 2e6, 3e6}), kWavelength);
  EXPECT_EQ(halo_kernel(nothing, 1e-5, 5).core, 1);
}

}  // namespace
}  // namespace aberfit
