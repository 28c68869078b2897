// Properties of the mean spot, and their derivatives, against closed forms and independent integrals.
#include "aberfit/theory/light_property.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/theory/geometric_harvey_shack.h"
#include "aberfit/theory/psd_jacobian.h"
#include "aberfit/theory/scatter_function.h"

namespace aberfit {
namespace {

using boost::math::cyl_bessel_j;
using std::numbers::pi;
using Gauss = boost::math::quadrature::gauss<double, 30>;

// f/500: the exact form equals the textbook's to 1/(32 N^2) = 1.3e-7, widths to 1/(16 N^2).
constexpr double kFocal = 100, kDiameter = 0.2, kWavelength = 500e-9;
constexpr double kAiry = kWavelength * kFocal / kDiameter;  // lambda N [m]
constexpr double kParaxial = 3e-7;

GhsPupil slow_pupil() { return {Mirror{kFocal, -1, {}}, CircleAperture{kDiameter}, kWavelength}; }

double value(const LightProperty& property, const PsdModel& psd, const GhsPupil& pupil = slow_pupil()) {
  return LightProperties({property}, pupil)(GeneralisedHarveyShack(RadialPsd(psd), pupil))[0];
}

const PsdModel kNearlyNothing = GaussianPsd{1e-16, 0.02};

double integral(const std::function<double(double)>& f, double a, double b, int pieces) {
  double sum = 0;
  for (int k = 0; k < pieces; ++k)
    sum += Gauss::integrate(f, a + (b - a) * k / pieces, a + (b - a) * (k + 1) / pieces);
  return sum;
}

double airy_irradiance(double r) {
  const double z = pi * r / kAiry, amplitude = z == 0 ? 1 : 2 * cyl_bessel_j(1, z) / z;
  return pi / (4 * kAiry * kAiry) * amplitude * amplitude;
}

double airy_transfer(double s) { return 2 / pi * (std::acos(s) - s * std::sqrt(1 - s * s)); }

// Transfer function of Gaussian roughness at a shear.
double gaussian_transfer(double rms, double length, double x) {
  return std::exp(std::pow(4 * pi * rms / kWavelength, 2) * std::expm1(-std::pow(x / length, 2)));
}

double sinc(double x) { return x == 0 ? 1 : std::sin(pi * x) / (pi * x); }

TEST(Ensquared, OfAnAiryPatternHoldsItsShareOfTheIrradiance) {
  for (const double fraction : {0.3, 0.8, 0.95}) {
    const double half = 0.5 * value(EnsquaredSide{fraction}, kNearlyNothing);
    const int pieces = 3 + int(half / kAiry);
    const double inside =
        4 *
        integral(
            [&](double x) {
              return integral([&](double y) { return airy_irradiance(std::hypot(x, y)); }, 0, half, pieces);
            },
            0, half, pieces);
    EXPECT_NEAR(inside, fraction, kParaxial) << fraction;
  }
}

// erf(a/(2 sqrt2 sigma))^2 for a Gaussian spot that is 1,000 times as wide as the Airy pattern. Error: its
// halo 2/(pi^2 r/lambda N).
TEST(Ensquared, OfAGaussianSpotIsItsClosedForm) {
  const double sigma = 1000 * kAiry, length = 100 * kDiameter;
  const double rms = sigma / (2 * kFocal) * length / std::numbers::sqrt2;
  const double side = value(EnsquaredSide{0.8}, GaussianPsd{rms, length});
  EXPECT_NEAR(std::pow(std::erf(side / (2 * std::numbers::sqrt2 * sigma)), 2), 0.8, 3e-4);
  EXPECT_NEAR(value(IrradianceFwhm{}, GaussianPsd{rms, length}) / (sigma * std::sqrt(8 * std::log(2.0))), 1,
              3e-4);
}

// int OTF a^2 sinc(a nx) sinc(a ny) d2n, in polar coordinates over the closed transfer function.
TEST(Ensquared, OfARoughMirrorIsTheTransformOfItsTransferFunction) {
  const double rms = 40e-9, length = 0.03;
  for (const double fraction : {0.5, 0.9}) {
    const double side = value(EnsquaredSide{fraction}, GaussianPsd{rms, length});
    const double scaled = side / kAiry;  // times nu of the cutoff
    const auto ring = [&](double s) {
      double mean = 0;
      constexpr int kDirections = 240;
      for (int k = 0; k < kDirections; ++k) {
        const double angle = pi / 2 * (k + 0.5) / kDirections;
        mean += sinc(scaled * s * std::cos(angle)) * sinc(scaled * s * std::sin(angle)) / kDirections;
      }
      return 2 * pi * s * scaled * scaled * mean * airy_transfer(s) *
             gaussian_transfer(rms, length, s * kDiameter);
    };
    EXPECT_NEAR(integral(ring, 0, 1, 24), fraction, 1e-6) << fraction;
  }
}

// The irradiance is dEE/dr over 2 pi r.
TEST(Irradiance, AndItsSlopeAreDerivativesOfEncircledEnergy) {
  const Mirror mirror{kFocal, -1, {}};
  const GhsPupil pupil(mirror, CircleAperture{kDiameter}, kWavelength);
  const MeanSpot spot = GeneralisedHarveyShack(RadialPsd(GaussianPsd{30e-9, 0.03}), pupil).at_plane(0);
  for (const double r : {0.3 * kAiry, 1.7 * kAiry}) {
    const auto derivative = [&](const std::function<double(double)>& f) {
      const double h = 1e-3 * kAiry;
      return (8 * (f(r + h) - f(r - h)) - (f(r + 2 * h) - f(r - 2 * h))) / (12 * h);
    };
    const double top = spot.irradiance(0);
    EXPECT_NEAR(spot.irradiance(r) / top,
                derivative([&](double at) { return spot.encircled_energy(at); }) / (2 * pi * r * top), 1e-9);
    EXPECT_NEAR(spot.irradiance_slope(r) * kAiry / top,
                derivative([&](double at) { return spot.irradiance(at); }) * kAiry / top, 1e-9);
  }
  EXPECT_NEAR(spot.irradiance(1e-6 * kAiry) / spot.irradiance(0), 1, 1e-10);
  // Both transfer functions at half of the cutoff, with the core.
  EXPECT_NEAR(spot.transfer(0.5 / kAiry),
              airy_transfer(0.5) * gaussian_transfer(30e-9, 0.03, 0.5 * kDiameter), 1e-6);
}

TEST(IrradianceWidth, OfAnAiryPattern) {
  // 2 J1(z)/z = sqrt(1/2).
  const double z =
      boost::math::tools::bisect([](double t) { return 2 * cyl_bessel_j(1, t) / t - std::sqrt(0.5); }, 1.0,
                                 2.0, boost::math::tools::eps_tolerance<double>(50))
          .first;
  EXPECT_NEAR(2 * z / pi, 1.0290, 1e-4);
  EXPECT_NEAR(value(IrradianceFwhm{}, kNearlyNothing) / (2 * z / pi * kAiry), 1, kParaxial);
}

// With one wave of defocus the axis is dark: width of the ring about it, by Fresnel's integral.
TEST(IrradianceWidth, OfARingIsThatOfItsOuterEdge) {
  const double n = kFocal / kDiameter;
  for (const double waves : {0.3, 1.0, 2.2}) {
    const double dz = 8 * n * n * kWavelength * waves;
    const double stretch = 1 + dz / kFocal;
    const auto irradiance = [&](double r) {
      const auto part = [&](double phase) {
        return integral(
            [&](double rho) {
              return rho * cyl_bessel_j(0, pi * r / (kAiry * stretch) * rho) *
                     std::cos(2 * pi * waves / stretch * rho * rho + phase);
            },
            0, 1, 4);
      };
      return std::pow(part(0), 2) + std::pow(part(-pi / 2), 2);
    };
    double top = 0, at = 0, r = 0;
    for (const double step = kAiry / 400; r < 20 * kAiry; r += step) {
      const double here = irradiance(r);
      if (here > top) top = here, at = r;
      if (here < 0.5 * top) break;
    }
    EXPECT_EQ(at > 0, waves > 0.5) << waves;
    EXPECT_NEAR(value(IrradianceFwhm{dz}, kNearlyNothing) / kAiry, 2 * r / kAiry, 4.0 / 400) << waves;
  }
}

// Kolmogorov turbulence with the structure function 6.88 (x/r0)^(5/3).
PsdModel turbulence(double r0) {
  const double amplitude = 0.02289558710855518 * std::pow(r0, -5.0 / 3) * std::pow(kWavelength / (4 * pi), 2);
  return PowerLawPsd{{}, amplitude, 11.0 / 3, 0, 1e4 / r0};
}

TEST(IrradianceWidth, OfALongExposureIsTheSeeing) {
  // For an infinite aperture, in lambda/r0.
  const auto irradiance = [](double w) {
    return integral(
        [&](double x) {
          return x * cyl_bessel_j(0, 2 * pi * w * x) * std::exp(-3.4419385887 * std::pow(x, 5.0 / 3));
        },
        0, 5, 40);
  };
  const double top = irradiance(0);
  const double half = boost::math::tools::bisect([&](double w) { return irradiance(w) - 0.5 * top; }, 0.1,
                                                 1.0, boost::math::tools::eps_tolerance<double>(40))
                          .first;
  EXPECT_NEAR(2 * half, 0.976, 5e-4);
  // The aperture's own transfer function falls by 4 x/(pi D): 3 % where D = 20 r0, 1e-3 at 700.
  const double wide = value(IrradianceFwhm{}, turbulence(kDiameter / 2000));
  EXPECT_NEAR(wide / (2 * half * kWavelength * kFocal / (kDiameter / 2000)), 1, 1e-3);
}

// r0^2 of both together over r0^2 of the air.
TEST(PointSource, OfATurbulentMirrorIsTheLawOfSumsOfTurbulence) {
  const double air = kDiameter / 1000;
  for (const double ratio : {0.2, 1.0, 3.0}) {  // r0 of the air over that of the mirror
    const double expected = std::pow(1 + std::pow(ratio, 5.0 / 3), -6.0 / 5);
    EXPECT_NEAR(value(PointSourceSensitivity{air}, turbulence(air / ratio)), expected, 2e-3 * expected)
        << ratio;
  }
  // r0 is scaled from 500 nm: at 1 um the air has an r0 that is 2^(6/5) times as long.
  const GhsPupil red(Mirror{kFocal, -1, {}}, CircleAperture{kDiameter}, 2 * kWavelength);
  EXPECT_NEAR(value(PointSourceSensitivity{air}, turbulence(air), red), std::pow(2.0, -6.0 / 5), 3e-3)
      << "a mirror's heights scale as the air's path does";
}

TEST(PointSource, OfAMirrorIsTheIntegralOverItsTransferFunction) {
  const double rms = 40e-9, length = 0.03, r0 = 0.15;
  const auto square = [&](bool rough) {
    return integral(
        [&](double s) {
          const double x = s * kDiameter;
          const double own = airy_transfer(s) * (rough ? gaussian_transfer(rms, length, x) : 1);
          return s * own * own * std::exp(-6.8838771774 * std::pow(x / r0, 5.0 / 3));
        },
        0, 1, 200);
  };
  const double found = value(PointSourceSensitivity{r0}, GaussianPsd{rms, length});
  EXPECT_NEAR(found, square(true) / square(false), 1e-6);
  EXPECT_LT(found, 0.6);
  EXPECT_NEAR(value(PointSourceSensitivity{}, kNearlyNothing), 1, 1e-9);
}

// Rayleigh-Rice without polarisation: 16 pi^2/lambda^4 S(sin(theta)/lambda) for a smooth surface.
TEST(PatchScatter, OfASmoothSurfaceIsItsPsd) {
  const PsdModel psd = KCorrelationPsd{1e-10, 1e-3, 2.4};
  const RadialPsd s{psd};
  for (const double theta : {0.01, 0.1, 0.7}) {
    const double expected = 16 * pi * pi / std::pow(kWavelength, 4) * s(std::sin(theta) / kWavelength);
    EXPECT_NEAR(value(PatchBsdf{theta}, psd) / expected, 1, 1e-4) << theta;
  }
}

// A sixth-order difference.
double log_derivative(const std::function<double(double log)>& f, double h) {
  return (45 * (f(h) - f(-h)) - 9 * (f(2 * h) - f(-2 * h)) + (f(3 * h) - f(-3 * h))) / (60 * h);
}

void expect_derivatives(const PsdModel& model, const GhsPupil& pupil,
                        const std::vector<LightProperty>& properties, double tolerance) {
  const LightProperties light(properties, pupil);
  const std::vector<PsdVariable> variables = psd_variables(model);
  const std::vector<Statistic> beside{RmsHeight{}};
  const PsdJacobian found = psd_jacobian(model, variables, beside, pupil, 1, &light);
  ASSERT_EQ(found.values.size(), Eigen::Index(properties.size()) + 1);
  const Eigen::MatrixXd logarithmic = found.logarithmic();
  for (std::size_t k = 0; k < variables.size(); ++k) {
    std::vector<Eigen::VectorXd> moved;
    constexpr double kStep = 3e-3;
    for (int side = -3; side <= 3; ++side) {
      const PsdModel other =
          with_value(model, variables[k], value_of(model, variables[k]) * std::exp(side * kStep));
      moved.push_back(light(GeneralisedHarveyShack(RadialPsd(other), pupil)));
    }
    for (std::size_t i = 0; i < properties.size(); ++i) {
      const auto row = Eigen::Index(i);
      const double expected = log_derivative(
          [&](double log) { return std::log(moved[std::size_t(3 + std::lround(log / kStep))][row]); }, kStep);
      EXPECT_NEAR(logarithmic(row + 1, Eigen::Index(k)), expected,
                  tolerance * std::max(1.0, std::abs(expected)))
          << "property " << i << " over " << pointer_of(variables[k]);
    }
  }
}

TEST(LightJacobian, MeetsDifferencesOfTheTheory) {
  const std::vector<LightProperty> all{StrehlRatio{},
                                       TotalScatter{},
                                       ModulationTransfer{0.3 / kAiry},
                                       EnsquaredSide{0.8},
                                       EnsquaredSide{0.7, 0.3},
                                       IrradianceFwhm{},
                                       IrradianceFwhm{1.2},
                                       PointSourceSensitivity{0.15}};
  expect_derivatives(GaussianPsd{45e-9, 0.03}, slow_pupil(), all, 2e-8);
}

TEST(LightJacobian, OfAFastAnnulusWithAberrationsMeetsDifferencesOfTheTheory) {
  const Mirror mirror{2.4, -0.9995, {}};
  const GhsPupil pupil(mirror, AnnulusAperture{1.2, 0.36}, 550e-9);
  const std::vector<LightProperty> all{StrehlRatio{},      TotalScatter{},   ModulationTransfer{2e5},
                                       EnsquaredSide{0.8}, IrradianceFwhm{}, PointSourceSensitivity{0.2}};
  expect_derivatives(KCorrelationPsd{17e-9, 0.3, 3, 1, 100}, pupil, all, 1e-7);
}

// Statistics and properties must have the same values and derivatives over the PSD.
TEST(LightJacobian, OfStatisticsIsThatOfTheSameProperties) {
  const PsdModel psd = KCorrelationPsd{50e-9, 0.05, 3, 5, 400};
  const GhsPupil pupil(Mirror{0.6, -1, {}}, AnnulusAperture{0.2, 0.06}, kWavelength);
  const std::vector<LightProperty> wanted = {StrehlRatio{}, ModulationTransfer{2e5}};
  const LightProperties light(wanted, pupil);
  const PsdJacobian found =
      psd_jacobian(psd, psd_variables(psd), {StrehlRatio{}, ModulationTransfer{2e5}}, pupil, 2, &light);
  ASSERT_EQ(found.values.size(), 4);
  for (Eigen::Index k = 0; k < 2; ++k) {
    EXPECT_NEAR(found.values[k], found.values[k + 2], 1e-13);
    EXPECT_GT(found.values[k], 0.05);
    EXPECT_LT((found.derivatives.row(k) - found.derivatives.row(k + 2)).norm(),
              1e-12 * found.derivatives.row(k).norm());
  }
  // For the side that holds 80 %, the energy in the square has the matching derivative.
  const LightProperties sides({EnsquaredSide{0.8, 1e-5}}, pupil);
  const double side = sides(GeneralisedHarveyShack(RadialPsd(psd), pupil))[0];
  const PsdJacobian square =
      psd_jacobian(psd, psd_variables(psd), {EnsquaredThrough{side, 1e-5}}, pupil, 1, &sides);
  EXPECT_NEAR(square.values[0], 0.8, 1e-10);
  const double slope =
      GeneralisedHarveyShack(RadialPsd(psd), pupil).at_plane(1e-5).ensquared_energy_slope(side);
  EXPECT_LT((square.derivatives.row(0) + slope * square.derivatives.row(1)).norm(),
            1e-9 * square.derivatives.row(0).norm());
  EXPECT_THROW(GeometricHarveyShack(Mirror{0.6, -1, {}}, CircleAperture{0.2}, 1e-6, Convention::kPhysical,
                                    1e-8)(StrehlRatio{}),
               ComputationError);
}

TEST(LightJacobian, OfTurbulenceFollowsItsLaw) {
  const double r0 = kDiameter / 1000;
  const GhsPupil pupil = slow_pupil();
  const LightProperties light({PointSourceSensitivity{r0}, IrradianceFwhm{}}, pupil);
  const std::vector<PsdVariable> amplitude{{"amplitude", {}, 0}};
  const Eigen::MatrixXd found = psd_jacobian(turbulence(r0), amplitude, {}, pupil, 1, &light).logarithmic();
  EXPECT_NEAR(found(0, 0), -6.0 / 5 / 2, 1e-3) << "(1 + u)^(-6/5) at u = 1, which is as the amplitude";
  EXPECT_NEAR(found(1, 0), 3.0 / 5, 1e-3) << "1/r0";
}

TEST(LightJacobian, OfAPatchIsADifference) {
  const LightProperties light({PatchBsdf{0.2}}, slow_pupil());
  const PsdModel smooth = KCorrelationPsd{1e-10, 1e-3, 2.4};
  const std::vector<PsdVariable> height{{"rms", {}, 0}};
  EXPECT_NEAR(psd_jacobian(smooth, height, {}, slow_pupil(), 1, &light).logarithmic()(0, 0), 2, 1e-5);
}

}  // namespace
}  // namespace aberfit
