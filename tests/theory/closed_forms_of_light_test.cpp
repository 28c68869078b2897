// Spots with closed forms from the literature: Cauchy's focus, Fried's long exposure, the orders of a
// grating, and a published example of scatter at another wavelength.
#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "aberfit/roughness/k_correlation.h"
#include "aberfit/specify/contributors.h"
#include "aberfit/theory/light_property.h"
#include "aberfit/theory/regime.h"
#include "aberfit/waves/diffraction_peak.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {
namespace {

using std::numbers::pi;
using Gauss = boost::math::quadrature::gauss<double, 60>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// S = A f^-3 without limits has the structure function 8 pi^2 A x and the transfer function exp(-2 pi g
// x/lambda), g = 32 pi^3 A/lambda [rad]. At shears much shorter than the aperture, the aperture has exp(-2 pi
// (2 lambda/(pi^2 D)) x/lambda). So EE(r) = 1 - g/sqrt(g^2 + r^2), I ~ (g^2 + r^2)^(-3/2).
TEST(ClosedForms, RoughnessOfTheThirdPowerHasCauchysFocus) {
  constexpr double kWave = 550e-9, kDiameter = 4, kFocal = 400, kAngle = 20e-6;
  const double amplitude = kAngle * kWave / (32 * std::pow(pi, 3));
  const GhsPupil pupil(Mirror{kFocal, -1, {}}, CircleAperture{kDiameter}, kWave);
  const GeneralisedHarveyShack light(RadialPsd(PowerLawPsd{{}, amplitude, 3, 0, kInfinity}), pupil);
  const MeanSpot spot = light.at_plane(0);
  const double g = kAngle + 2 * kWave / (pi * pi * kDiameter);
  for (const double share : {0.2, 0.5, 0.8, 0.9}) {
    const double angle = g * std::sqrt(std::pow(1 - share, -2) - 1);
    EXPECT_NEAR(spot.encircled_energy_radius(share) / kFocal / angle, 1, 2e-4) << share;
  }
  EXPECT_NEAR(spot.fwhm() / kFocal / (2 * g * std::sqrt(std::cbrt(4.0) - 1)), 1, 2e-4);
}

// Fried (1966), long exposures: the Strehl ratio is the mean of the transfer function.
TEST(ClosedForms, StrehlRatioThroughTurbulenceIsFrieds) {
  constexpr double kWave = 500e-9, kDiameter = 1, kFocal = 200;
  const GhsPupil pupil(Mirror{kFocal, -1, {}}, CircleAperture{kDiameter}, kWave);
  const auto strehl = [&](const Atmosphere& air) {
    return LightProperties({StrehlRatio{}},
                           pupil)(GeneralisedHarveyShack(RadialPsd(in_pupil(air)), pupil))[0];
  };
  const auto mean = [](const auto& transfer) {
    const auto of = [&](double s) {
      return 16 / pi * s * (std::acos(s) - s * std::sqrt(1 - s * s)) * transfer(s);
    };
    double sum = 0;
    for (int k = 0; k < 40; ++k) sum += Gauss::integrate(of, k / 40.0, (k + 1) / 40.0);
    return sum;
  };
  for (const auto& [ratio, known] : {std::pair{1.0, 0.44460}, {2.0, 0.17472}, {5.0, 0.035095}}) {
    const double fried =
        mean([r = ratio](double s) { return std::exp(-3.4419386 * std::pow(s * r, 5.0 / 3)); });
    EXPECT_NEAR(fried / known, 1, 4e-5) << ratio;  // printed digits
    EXPECT_NEAR(strehl({kDiameter / ratio, kWave}) / fried, 1, 5e-5) << ratio;
  }
  // Von Karman's structure function: 0.17263 (L0/r0)^(5/3) (1 - 2^(1/6)/Gamma(5/6) t^(5/6) K_5/6(t)), t = 2
  // pi x/L0. It saturates, so a small outer scale leaves a core.
  for (const double scale : {100.0, 4.0, 0.5}) {
    const double r0 = kDiameter / 2;
    const auto transfer = [&](double s) {
      const double t = 2 * pi * s * kDiameter / scale;
      const double fall = t == 0 ? 1
                                 : std::pow(2, 1.0 / 6) / std::tgamma(5.0 / 6) * std::pow(t, 5.0 / 6) *
                                       boost::math::cyl_bessel_k(5.0 / 6, t);
      return std::exp(-0.5 * 0.1726287 * std::pow(scale / r0, 5.0 / 3) * (1 - fall));
    };
    EXPECT_NEAR(strehl({r0, kWave, scale}) / mean(transfer), 1, 1e-4) << scale;
  }
}

// A cosine of height a with m cycles across a square is a grating whose order n holds J_n(4 pi a/lambda)^2 of
// the energy. Where one order is highest, all others are zero. A tilt brings it to the axis.
TEST(ClosedForms, OrdersOfASinusoidAreBesselFunctions) {
  constexpr double kWave = 632.8e-9, kSide = 0.2;
  constexpr int kCycles = 8;
  const DiffractionPupil pupil = diffraction_pupil(RectangleAperture{kSide, kSide}, kParaxial, kSide / 256);
  const DiffractionProblem problem{pupil, 2.0, kWave};
  const Eigen::ArrayXd turn = 2 * pi * kCycles / kSide * pupil.sample.x;
  for (const double nanometres : {10.0, 60.0, 150.0})
    for (const int order : {0, 1, -1, 2, 5}) {
      const Eigen::ArrayXd tilt = 0.5 * kWave * order / (2 * pi) * turn;
      const double known = boost::math::cyl_bessel_j(order, 4 * pi * nanometres * 1e-9 / kWave);
      EXPECT_NEAR(diffraction_peak(problem, nanometres * 1e-9 * turn.cos() + tilt).axis_ratio, known * known,
                  1e-5)
          << nanometres << ' ' << order;
    }
}

// Zemax' example of a K-correlation surface, B = 5.02655 um, s = 3. The frequencies that scatter at 632.8 nm
// have 3 nm RMS; at 300 nm they have 3.10996 nm and scatter 1.682 % of the energy.
TEST(ClosedForms, ScatterAtAnotherWavelengthIsThatOfZemaxExample) {
  constexpr double kB = 5.02655e-6, kMeasured = 632.8e-9, kUsed = 300e-9;
  const KCorrelationPsd in_band{3e-9, kB, 3, 0, 1 / kMeasured};
  const double amplitude = RadialPsd(in_band)(0);
  const PsdModel whole = k_correlation_model({amplitude, kB, 3});
  const SceneNumbers numbers =
      scene_numbers(RadialPsd(whole), Mirror{10, -1, {}}, CircleAperture{0.1}, kUsed);
  EXPECT_NEAR(numbers.relevant_rms_height / 3.10996e-9, 1, 2e-6);
  EXPECT_NEAR(numbers.tis, 0.01682, 1e-5);
}

}  // namespace
}  // namespace aberfit
