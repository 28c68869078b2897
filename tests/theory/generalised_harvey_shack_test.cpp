#include "aberfit/theory/generalised_harvey_shack.h"

#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <numbers>
#include <tuple>

#include "aberfit/core/errors.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/theory/geometric_harvey_shack.h"
#include "golden_csv.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

const Mirror kParabola{2.8, -1, {}};
const Aperture kCircle = CircleAperture{0.4};
const Aperture kAnnulus = AnnulusAperture{0.4, 0.15};
constexpr double kLambda = 632.8e-9;
// Relative, for every golden radius; the largest error seen is 1e-11.
constexpr double kGolden = 1e-6;
constexpr double kConverged = 1e-9;  // for encircled energies, as the header promises
constexpr double kDigits = 1e-10;
// The same aperture at f/70000: position and direction agree to 1/(32 N^2) = 6e-12.
constexpr double kSlower = 1e4;
const Mirror kSlow{2.8 * kSlower, -1, {}};

double number(const GoldenRow& row, const std::string& column) { return std::stod(row.at(column)); }

RadialPsd golden_psd(const GoldenRow& row) {
  const double l = number(row, "l_m"), sigma = number(row, "sigma_m");
  // ACF (1 + x/l) exp(-x/l) has the PSD of exponent 5 with B = 2 pi l.
  if (row.at("acf") == "c5") return RadialPsd(KCorrelationPsd{sigma, 2 * pi * l, 5.0});
  if (row.at("acf") == "gauss") return RadialPsd(GaussianPsd{sigma, l});
  throw std::runtime_error("unknown acf " + row.at("acf"));
}

// One PSD of each model, with smooth and oscillating autocorrelations.
std::vector<RadialPsd> families() {
  const TablePsd table{{2, 5, 11, 40, 80}, {3e-17, 5e-17, 1e-17, 2e-18, 4e-19}};
  return {RadialPsd(GaussianPsd{60e-9, 0.02}),
          RadialPsd(UniformPsd{100e-9, 2.5, 39.92}),
          RadialPsd(KCorrelationPsd{40e-9, 0.1, 2.6}),
          RadialPsd(PowerLawPsd{30e-9, {}, 3.1, 2.5, 400}),
          RadialPsd(table),
          RadialPsd(SumPsd{{GaussianPsd{20e-9, 0.1}, UniformPsd{20e-9, 30, 200}}})};
}

}  // namespace

TEST(GeneralisedHarveyShack, RefusesPlanesThatDoNotExist) {
  const GeneralisedHarveyShack model(RadialPsd(GaussianPsd{60e-9, 0.02}), kParabola, kCircle, kLambda);
  for (const double dz : {-2.8, -4.0, HUGE_VAL, -HUGE_VAL, std::nan("")}) {
    EXPECT_THROW(model.at_plane(dz), ComputationError) << dz;
    EXPECT_THROW(model.predict({EncircledEnergyRadius{0.5, 0}, RingThrough{1e-5, dz}}), ComputationError)
        << dz;
  }
}

// The golden rows are paraxial by definition.
TEST(GeneralisedHarveyShack, OfASlowMirrorMatchesEveryGoldenRadius) {
  int rows = 0;
  double worst = 0;
  for (const GoldenRow& row : read_golden("ghs_ee.csv")) {
    ++rows;
    const RadialPsd psd = golden_psd(row);
    const GeneralisedHarveyShack waves(psd, kSlow, kCircle, kLambda);
    const auto check = [&](double fraction, const std::string& column) {
      const double error = waves.encircled_energy_radius(fraction, 0) / (kSlower * number(row, column)) - 1;
      worst = std::max(worst, std::abs(error));
      EXPECT_NEAR(error, 0, kGolden) << row.at("acf") << " " << row.at("l_m") << " " << row.at("sigma_m")
                                     << column;
    };
    check(0.5, "ee50_ghs");
    check(0.8, "ee80_ghs");
    check(0.9, "ee90_ghs");
    EXPECT_NEAR(waves.g() / number(row, "g"), 1, 1e-11);
    EXPECT_NEAR(waves.core_share(), number(row, "core_fraction"), 1e-11);
    EXPECT_NEAR(waves.core_share() + waves.tis(), 1, 1e-15);
    EXPECT_EQ(waves.unresolved(), 0);
  }
  EXPECT_EQ(rows, 24);
  RecordProperty("worst_error_of_waves_in_1e_12", std::to_string(worst * 1e12));
}

TEST(GeneralisedHarveyShack, WithoutRoughnessIsTheAiryPattern) {
  const GeneralisedHarveyShack smooth(RadialPsd(GaussianPsd{1e-16, 0.01}), kSlow, kCircle, kLambda);
  const double scale = pi * 0.4 / (kLambda * 2.8);
  for (const double r : {1e-8, 1e-6, 3e-6, 1e-5, 1e-4, 1e-2}) {
    const double j0 = boost::math::cyl_bessel_j(0, scale * r), j1 = boost::math::cyl_bessel_j(1, scale * r);
    EXPECT_NEAR(smooth.encircled_energy(kSlower * r, 0), 1 - j0 * j0 - j1 * j1, 1e-11);
  }
  // Radii in lambda f / D that hold 50, 80, 90 %: roots of J0^2 + J1^2 = 1 - p.
  for (const auto& [p, radius] :
       {std::pair{0.5, 0.534832147724265}, {0.8, 0.896942102550488}, {0.9, 1.90068797783025}})
    EXPECT_NEAR(smooth.encircled_energy_radius(p, 0) / (kLambda * 7 * kSlower) / radius, 1, 5e-11) << p;
}

TEST(GeneralisedHarveyShack, WithoutRoughnessIsTheAnnularPattern) {
  // Irradiance from the amplitude 2 J1(z)/z - e^2 2 J1(e z)/(e z), integrated by Gauss-Legendre.
  const double e = 0.15 / 0.4;
  const GeneralisedHarveyShack smooth(RadialPsd(GaussianPsd{1e-16, 0.01}), kSlow, kAnnulus, kLambda);
  for (const double r : {1e-6, 3e-6, 2e-5}) {
    const double end = pi * 0.4 * r / (kLambda * 2.8);
    const Quadrature rule = gauss_legendre(200, 0, end);
    double sum = 0;
    for (int i = 0; i < 200; ++i) {
      const double z = rule.nodes[i];
      const double amplitude = boost::math::cyl_bessel_j(1, z) - e * boost::math::cyl_bessel_j(1, e * z);
      sum += rule.weights[i] * 2 * amplitude * amplitude / z / (1 - e * e);
    }
    EXPECT_NEAR(smooth.encircled_energy(kSlower * r, 0), sum, 1e-11) << r;
  }
}

TEST(GeneralisedHarveyShack, OfAVeryRoughSurfaceIsGeometric) {
  // g = 200: the ACF is quadratic where it matters, to 1/g^2; the Airy pattern is 1/5000 of the spot.
  const double sigma = 200 * kLambda / (4 * pi), l = 0.02;
  const RadialPsd psd(GaussianPsd{sigma, l});
  const double slope = psd_moments(psd).rms_slope_per_axis();
  const GeneralisedHarveyShack waves(psd, kParabola, kCircle, kLambda);
  const GeometricHarveyShack rays(kParabola, kCircle, slope, Convention::kPhysical, sigma);
  // The 1/r tail of the Airy pattern holds 1.5e-4 of the energy; it moves ee95 most, by 4.3e-4.
  constexpr double kTail = 6e-4;
  for (const double p : {0.2, 0.5, 0.8, 0.9, 0.95})
    for (const double spread : {0.0, 1.0, -3.5, 5.0}) {
      const double dz = spread * 2 * slope * 2.8 * 14;
      EXPECT_NEAR(waves.encircled_energy_radius(p, dz) / rays.encircled_energy_radius(p, dz), 1, kTail)
          << p << " " << spread;
    }
  const double ring = waves.encircled_energy_radius(0.9, 0);
  EXPECT_NEAR(waves.ring_fwhm(ring) / rays.ring_fwhm(ring), 1, kTail);
  // The law holds for a shallow focus; this one is f/8 wide and 0.1 (w/f)^2 narrower.
  const double depth = waves.ring_fwhm(ring) / 2.8;
  EXPECT_NEAR(waves.ring_fwhm(ring) / (2.80675977 * ring * 14), 1 - 0.1 * depth * depth, 5e-4);
  EXPECT_NEAR(waves.spot_fwhm(0) / (std::sqrt(8 * std::log(2.0)) * 2 * 2.8 * slope), 1, 1e-3);
  EXPECT_DOUBLE_EQ(waves.scatter_rms(), rays.scatter_rms());
  EXPECT_DOUBLE_EQ(waves(ScatterMean{}), rays.scatter_mean());
}

TEST(GeneralisedHarveyShack, HalvingEveryPanelChangesNothing) {
  double worst = 0;
  for (const RadialPsd& psd : families())
    for (const Aperture& aperture : {kCircle, kAnnulus, Aperture(RectangleAperture{0.3, 0.2})}) {
      const GeneralisedHarveyShack once(psd, kParabola, aperture, kLambda);
      const GeneralisedHarveyShack twice(psd, kParabola, aperture, kLambda, {.halvings = 1});
      const double same = std::holds_alternative<RectangleAperture>(aperture) ? 1e-5 : kConverged;
      EXPECT_EQ(once.unresolved(), 0);
      for (const double dz : {0.0, 1e-4, -2e-3}) {
        const MeanSpot a = once.at_plane(dz), b = twice.at_plane(dz);
        for (const double r : {1e-6, 3e-6, 1e-5, 5e-5, 2e-4, 1e-3}) {
          EXPECT_NEAR(a.encircled_energy(r), b.encircled_energy(r), same);
          worst = std::max(worst, std::abs(a.encircled_energy(r) - b.encircled_energy(r)));
        }
      }
    }
  RecordProperty("worst_change_in_1e_12", std::to_string(worst * 1e12));
}

TEST(GeneralisedHarveyShack, AgreesWithBruteForceQuadratureOffFocus) {
  // EE as the integral of OTF(nu) J1 on midpoints, the OTF a double sum over the overlap of two circles.
  const RadialPsd psd(GaussianPsd{80e-9, 0.05});
  const double f = 280, D = 0.4, dz = 3, c = 2 * pi * dz / (kLambda * f * (f + dz)),
               g = 4 * pi * 80e-9 / kLambda;
  const GeneralisedHarveyShack waves(psd, Mirror{f, -1, {}}, kCircle, kLambda);
  const int n = 4000;
  for (const double r : {4e-4, 2e-3, 6e-3}) {
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      const double x = D * (i + 0.5) / n, end = 0.5 * (D - x);
      double otf = 0;
      for (int k = 0; k < 400; ++k) {
        const double u = end * (k + 0.5) / 400;
        otf += 2 * (end / 400) * 2 * std::sqrt(0.25 * D * D - std::pow(u + 0.5 * x, 2)) * std::cos(c * x * u);
      }
      otf /= 0.25 * pi * D * D;
      const double transfer = otf * std::exp(-g * g * -std::expm1(-std::pow(x / 0.05, 2)));
      sum += 2 * pi * r / (kLambda * (f + dz)) * (D / n) * transfer *
             boost::math::cyl_bessel_j(1, 2 * pi * r * x / (kLambda * (f + dz)));
    }
    EXPECT_NEAR(waves.encircled_energy(r, dz), sum, 3e-5)
        << r;  // midpoint rule at a square-root end: 400^-1.5
  }
}

TEST(GeneralisedHarveyShack, EncircledEnergyRisesFromZeroToOneAndItsRadiiInvertIt) {
  for (const RadialPsd& psd : families())
    for (const double dz : {0.0, 5e-4}) {
      const GeneralisedHarveyShack waves(psd, kParabola, kCircle, kLambda);
      const MeanSpot spot = waves.at_plane(dz);
      double last = 0;
      for (double r = 1e-9; r < 0.5; r *= 1.1) {
        const double here = spot.encircled_energy(r);
        EXPECT_GE(here, last - 1e-10) << r;
        if (r < 3e-4) {  // beyond, the ripples of the core are narrower than h
          const double h = 1e-4 * r;
          const double difference = (spot.encircled_energy(r + h) - spot.encircled_energy(r - h)) / (2 * h);
          EXPECT_NEAR(spot.encircled_energy_slope(r) * r, difference * r, 1e-5) << r;
        }
        last = here;
      }
      // Missing beyond 0.5 m: the Airy tail of 1e-6 and the outermost energy of the fractal.
      EXPECT_NEAR(last, 1, 2e-3);
      for (const double p : {0.02, 0.2, 0.5, 0.8, 0.9, 0.95, 0.99})
        EXPECT_NEAR(spot.encircled_energy(spot.encircled_energy_radius(p)), p, kDigits) << p;
    }
}

TEST(GeneralisedHarveyShack, TooManyWavesOfAberrationSayWhatToDo) {
  const RadialPsd roughness(GaussianPsd{1e-10, 0.01});
  // Waves in the focus, and waves of defocus at a wavelength a thousand times as long.
  for (const auto& [sphere, wavelength, dz, where] :
       {std::tuple{Mirror{1.4, 0, {}}, 1e-10, 0.0, " waves in the focus, too many"},
        {Mirror{1.4, 0, {}}, 1e-7, 0.4, " waves in the plane 400 mm from the focus, too many"}}) {
    try {
      const GeneralisedHarveyShack light(roughness, sphere, CircleAperture{0.2}, wavelength);
      light.encircled_energy_radius(0.5, dz);
      FAIL() << "no refusal";
    } catch (const ComputationError& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find("take a mirror nearer to its parabola, or `\"theory\": \"geometric\"`"),
                std::string::npos)
          << what;
      EXPECT_NE(what.find(where), std::string::npos) << what;
    }
  }
}

TEST(GeneralisedHarveyShack, RefusesWhatHasNoPrediction) {
  const RadialPsd good(GaussianPsd{1e-8, 0.01}), endless(PowerLawPsd{{}, 1e-20, 4.0, 0, 100});
  const RadialPsd steep(KCorrelationPsd{1e-7, 0.1, 3.0});
  EXPECT_THROW(GeneralisedHarveyShack(endless, kParabola, kCircle, kLambda), ComputationError);
  EXPECT_THROW(GeneralisedHarveyShack(good, kParabola, CircleAperture{12}, kLambda), ComputationError);
  EXPECT_THROW(GeneralisedHarveyShack(good, Mirror{0.3, 3, {}}, CircleAperture{0.7}, kLambda),
               ComputationError);
  EXPECT_THROW(GeneralisedHarveyShack(good, kParabola, kCircle, kLambda,
                                      {.departure = [](double x, double) { return x / 0.0; }}),
               ComputationError);
  const GeneralisedHarveyShack waves(steep, kParabola, kCircle, kLambda);
  EXPECT_THROW(waves(RmsRadius{}), ComputationError);
  EXPECT_THROW(waves(ScatterRms{}), ComputationError);
  EXPECT_TRUE(std::isnan(waves.encircled_energy_radius(1.0, 0)));
  EXPECT_TRUE(std::isnan(waves.ring_fwhm(0)));
  EXPECT_GT(waves.encircled_energy_radius(0.5, 0), 0);
}

TEST(GeneralisedHarveyShack, OfARectangleAveragesItsDiffractionPattern) {
  const GeneralisedHarveyShack smooth(RadialPsd(GaussianPsd{1e-16, 0.01}), kSlow, RectangleAperture{0.3, 0.2},
                                      kLambda);
  // sinc^2 sinc^2 over a disc, polar Gauss-Legendre.
  const auto sinc = [](double z) { return z == 0 ? 1.0 : std::sin(z) / z; };
  const double k = pi / (kLambda * 2.8);
  for (const double r : {2e-6, 1e-5}) {
    const Quadrature radial = gauss_legendre(80, 0, r), turn = gauss_legendre(80, 0, pi / 2);
    double sum = 0;
    for (int i = 0; i < 80; ++i)
      for (int j = 0; j < 80; ++j) {
        const double x = radial.nodes[i] * std::cos(turn.nodes[j]),
                     y = radial.nodes[i] * std::sin(turn.nodes[j]);
        sum += 4 * radial.weights[i] * turn.weights[j] * radial.nodes[i] *
               std::pow(sinc(k * 0.3 * x) * sinc(k * 0.2 * y), 2);
      }
    EXPECT_NEAR(smooth.encircled_energy(kSlower * r, 0), sum * 0.06 / std::pow(kLambda * 2.8, 2), 1e-5) << r;
  }
}

TEST(GeneralisedHarveyShack, ASoftenedBandEdgeMovesLittleLight) {
  // 40,000 cycles across. Single scattering to g^2/2 = 5e-6: an even disc of radius lambda f f_max.
  const double f_max = 1e5, g = 0.003, edge = kLambda * 2.8 * f_max, scale = pi * 0.4 / (kLambda * 2.8);
  const GeneralisedHarveyShack waves(RadialPsd(UniformPsd{g * kLambda / (4 * pi), 2.5, f_max}), kSlow,
                                     kCircle, kLambda);
  EXPECT_EQ(waves.unresolved(), 0);
  const MeanSpot spot = waves.at_plane(0);
  for (const double part : {0.1, 0.4, 0.7, 0.9, 0.95, 1.05, 1.2}) {
    const double z = scale * part * edge, j0 = boost::math::cyl_bessel_j(0, z),
                 j1 = boost::math::cyl_bessel_j(1, z);
    const double scattered =
        (spot.encircled_energy(kSlower * part * edge) - waves.core_share() * (1 - j0 * j0 - j1 * j1)) /
        waves.tis();
    EXPECT_NEAR(scattered, std::min(1.0, part * part), 1e-4) << part;
  }
}

TEST(GeneralisedHarveyShack, PredictsManyStatisticsAsOneByOneForAnyThreadCount) {
  const GeneralisedHarveyShack waves(RadialPsd(UniformPsd{100e-9, 2.5, 39.92}), kParabola, kCircle, kLambda);
  std::vector<Statistic> statistics = {RingFwhm{}, RmsHeight{}, ScatterRms{}, SpotFwhm{1e-6}};
  for (const double dz : {0.0, 1e-3, -2e-3}) {
    for (const double p : {0.2, 0.5, 0.9}) statistics.push_back(EncircledEnergyRadius{p, dz});
    statistics.push_back(RingThrough{1e-4, dz});
  }
  const Eigen::VectorXd one = waves.predict(statistics), two = waves.predict(statistics, 2);
  for (std::size_t i = 0; i < statistics.size(); ++i) {
    EXPECT_EQ(one[Eigen::Index(i)], waves(statistics[i])) << i;
    EXPECT_EQ(one[Eigen::Index(i)], two[Eigen::Index(i)]) << i;
  }
  EXPECT_THROW(waves.predict({RmsRadius{}, RmsHeight{}}, 2), ComputationError);
}
