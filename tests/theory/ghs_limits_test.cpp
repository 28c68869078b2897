#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "short_form.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

constexpr double kLambda = 632.8e-9;

// Every statistic of a scene returns, and its encircled energies lie in [0, 1].
void expect_an_answer(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture, double wavelength,
                      const GhsOptions& options) {
  const GeneralisedHarveyShack waves(psd, mirror, aperture, wavelength, options);
  for (const double dz : {0.0, 0.01 * mirror.focal_length, -0.02 * mirror.focal_length}) {
    const MeanSpot spot = waves.at_plane(dz);
    for (const double p : {0.1, 0.5, 0.8, 0.9, 0.99}) {
      const double radius = spot.encircled_energy_radius(p);
      EXPECT_GT(radius, 0) << dz << " " << p;
      if (std::isfinite(radius)) {
        EXPECT_NEAR(spot.encircled_energy(radius), p, 1e-9) << dz << " " << p;
      }
    }
    EXPECT_TRUE(std::isnan(spot.encircled_energy(std::nan(""))));
    EXPECT_TRUE(std::isnan(spot.encircled_energy(HUGE_VAL)));
  }
  EXPECT_NO_THROW(waves.ring_fwhm(waves.encircled_energy_radius(0.5, 0)));
}

}  // namespace

TEST_WITH_SHORT_FORM(GhsLimits, MillimetreMirrorsAndCentimetreWavesEnd) {
  {
    const GhsOptions options;
    expect_an_answer(RadialPsd(UniformPsd{10e-6, 60, 300}), Mirror{0.112, -1, {}}, CircleAperture{0.016},
                     1e-2, options);
    expect_an_answer(RadialPsd(UniformPsd{0.25e-12, 1e6, 4.8e6}), Mirror{7e-6, -1, {}}, CircleAperture{1e-6},
                     kLambda, options);
    expect_an_answer(RadialPsd(UniformPsd{0.5 * kLambda / (4 * pi), 2.5, 40}), Mirror{3, -1, {}},
                     RectangleAperture{0.3, 0.3}, kLambda, options);
  }
}

TEST(GhsLimits, FarDefocusGoesOverIntoTheClosedFormWithoutAStep) {
  // Both sides of the switch between the two forms of the overlap, at fractions of the geometric blur.
  const Mirror mirror{1.2, -1, {}};  // f/3
  const GeneralisedHarveyShack smooth(RadialPsd(GaussianPsd{1e-12, 0.01}), mirror, CircleAperture{0.4},
                                      kLambda);
  // The phase across the overlap changes by about 2 pi R^2 |dz|/(2 lambda f^2).
  const double near = 1400 * kLambda * 72 / (2 * pi), far = 1600 * kLambda * 72 / (2 * pi);
  const MeanSpot direct = smooth.at_plane(near), closed = smooth.at_plane(far);
  for (const double part : {0.3, 0.6, 0.8, 1.2}) {
    const double blur = 0.2 / 1.2;  // over dz, paraxial
    EXPECT_NEAR(direct.encircled_energy(part * near * blur), closed.encircled_energy(part * far * blur), 4e-4)
        << part;
  }
}

TEST(GhsLimits, TheMeanOverTheApertureInterpolatesAnOrderFurtherAsTheMirrorGetsFaster) {
  // One plane of a fast mirror by brute force: the overlap integral with H on a fine grid of midpoints.
  const double f = 0.5, R = 0.2, sigma = 1.3 * kLambda / (4 * pi), l = 0.06;  // f/1.25
  const GeneralisedHarveyShack waves(RadialPsd(GaussianPsd{sigma, l}), Mirror{f, -1, {}},
                                     CircleAperture{2 * R}, kLambda);
  const double t = R / (2 * f), rim = R / (1 + t * t), dz = 2e-6;
  const auto cosine = [&](double x, double y) { return std::sqrt(1 - (x * x + y * y) / (f * f)); };
  const auto amplitude = [](double c) { return 2 / ((1 + c) * std::sqrt(c)); };
  for (const double x : {0.03, 0.1, 0.2}) {
    constexpr int kSide = 1200;
    double sum = 0, all = 0;
    const double step = 2 * rim / kSide;
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j) {
        const double u = -rim + (i + 0.5) * step, v = -rim + (j + 0.5) * step;
        if (std::hypot(u, v) < rim) all += std::pow(amplitude(cosine(u, v)), 2);
        if (std::hypot(std::abs(u) + 0.5 * x, v) >= rim) continue;
        const double c1 = cosine(u + 0.5 * x, v), c2 = cosine(u - 0.5 * x, v);
        const double q1 = 0.5 * (1 + c1), q2 = 0.5 * (1 + c2);  // r = P/q
        const double d2 = std::pow((u + 0.5 * x) / q1 - (u - 0.5 * x) / q2, 2) + std::pow(v / q1 - v / q2, 2);
        const double g = 4 * pi * sigma / kLambda;
        const double exponent = g * g * (q1 * q2 * std::expm1(-d2 / (l * l)) - 0.5 * std::pow(q1 - q2, 2));
        const double phase = 2 * pi / kLambda * dz / (1 + dz / f) * (c2 - c1);
        sum += amplitude(c1) * amplitude(c2) * std::cos(phase) * std::exp(exponent);
      }
    EXPECT_NEAR(waves.transfer(x, dz), sum / all, 1e-4) << x;  // grid cells at the rim
  }
}
