// Mean spots of rough mirrors against the double integral that they are an integral of: over all pairs of
// points of the aperture, with the coherence that the roughness leaves between the two where they lie. Theory
// has the pair's middle and shear alone, to the second order in the shear; it is asked here where that is
// hardest, of fast mirrors with few cycles across.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/theory/generalised_harvey_shack.h"

namespace aberfit {
namespace {

// A parabola's, of a roughness with Gaussian autocorrelation. Pupil coordinates P = f sin(theta), light even
// on the mirror, t = tan(theta/2), c = cos(theta) (PHYSICS 6).
class LightByPairs {
 public:
  LightByPairs(double f, double radius, double inner, double wavelength, double rms, double length)
      : f_(f), wavelength_(wavelength) {
    const auto pupil = [&](double r) { return r / (1 + r * r / (4 * f * f)); };
    const Quadrature radial = gauss_legendre(kRadial, pupil(inner), pupil(radius));
    std::vector<double> place, slant, weight;
    double all = 0;
    for (int i = 0; i < kRadial; ++i) {
      const double c = std::sqrt(1 - std::pow(radial.nodes[i] / f, 2)), t2 = (1 - c) / (1 + c);
      const double amplitude = 2 / ((1 + c) * std::sqrt(c)),
                   area = 2 * kPi * radial.nodes[i] * radial.weights[i];
      place.push_back(2 * f * std::sqrt(t2));
      slant.push_back(4 * kPi * rms / (wavelength * (1 + t2)));
      weight.push_back(amplitude * area);
      versine_.push_back(1 - c);
      all += amplitude * amplitude * area;
    }
    for (std::size_t i = 0; i < kRadial; ++i)
      for (std::size_t j = 0; j < kRadial; ++j)
        for (int a = 0; a < kAngles; ++a) {
          const double turn = std::cos(kPi * (a + 0.5) / kAngles);
          const auto apart2 = [turn](double one, double two) {
            return one * one + two * two - 2 * one * two * turn;
          };
          const double alike = std::exp(-apart2(place[i], place[j]) / (length * length));
          const double coherence =
              std::exp(-0.5 * slant[i] * slant[i] - 0.5 * slant[j] * slant[j] + slant[i] * slant[j] * alike);
          pairs_.push_back({std::sqrt(apart2(radial.nodes[int(i)], radial.nodes[int(j)])),
                            weight[i] * weight[j] * coherence / (kAngles * all), versine_[i] - versine_[j]});
        }
  }

  double encircled_energy(double r, double dz) const {
    const double image = wavelength_ * (f_ + dz), defocus = 2 * kPi / wavelength_ * dz / (1 + dz / f_);
    double sum = 0;
    for (const Pair& pair : pairs_) {
      const double x = 2 * kPi * r * pair.shear / image;
      const double kernel = x < 1e-6 ? kPi * r / image : std::cyl_bessel_j(1, x) / pair.shear;
      sum += pair.weight * std::cos(defocus * pair.versine) * kernel;
    }
    return sum * r / image;
  }

 private:
  static constexpr int kRadial = 56, kAngles = 72;
  struct Pair {
    double shear, weight, versine;
  };
  double f_, wavelength_;
  std::vector<double> versine_;
  std::vector<Pair> pairs_;
};

TEST(GhsPairs, MeanSpotsOfFastMirrorsAreThoseOfAllPairsOfPoints) {
  constexpr double kAcross = 0.2, kWave = 1e-6;
  struct Case {
    double f_number, inner, rms, length, off;
  };
  for (const Case of : {Case{2, 0, 0.35 * kWave, 0.03, 3e-5}, Case{1.5, 0.5, 0.05 * kWave, 0.05, 3e-5},
                        Case{1, 0, 0.2 * kWave, 0.04, 3e-5}, Case{1, 0.4, 0.2 * kWave, 0.04, 3e-5},
                        Case{1, 0, 0.05 * kWave, 0.05, 1.2e-4}, Case{1, 0, 0.08 * kWave, 0.05, 1.2e-4},
                        Case{1, 0, 0.12 * kWave, 0.08, 1.2e-4}, Case{0.75, 0, 0.08 * kWave, 0.05, 4e-4},
                        Case{0.5, 0, 0.08 * kWave, 0.05, 1.3e-3}}) {
    const double f = of.f_number * kAcross;
    const Aperture aperture = of.inner > 0 ? Aperture(AnnulusAperture{kAcross, of.inner * kAcross})
                                           : Aperture(CircleAperture{kAcross});
    const GeneralisedHarveyShack light(RadialPsd(GaussianPsd{of.rms, of.length}), Mirror{f}, aperture, kWave);
    const LightByPairs truth(f, 0.5 * kAcross, 0.5 * of.inner * kAcross, kWave, of.rms, of.length);
    double worst = 0;
    for (const double fraction : {0.25, 0.5, 0.68, 0.8}) {
      const double r = light.encircled_energy_radius(fraction, 0), depth = 2 * of.f_number * r;
      for (const double dz : {0.0, 0.5 * depth, -depth})
        worst = std::max(worst, std::abs(light.encircled_energy(r, dz) - truth.encircled_energy(r, dz)));
    }
    EXPECT_LT(worst, of.off) << "f/" << of.f_number << ", inner " << of.inner << ", rms " << of.rms;
  }
}

// Waves longer than the aperture tilt it, and longer still they lift it: of the same slopes, whatever their
// heights, the same light. They would be a defocus of their height otherwise, 1e-2 of the light here.
TEST(GhsPairs, HeightsOfTheMirrorAsAWholeMoveNoLight) {
  constexpr double kAcross = 0.2, kWave = 1e-6;
  for (const double f_number : {1.0, 3.0}) {
    const auto light = [&](double length) {
      constexpr double kSlope = 4e-6;
      return GeneralisedHarveyShack(RadialPsd(GaussianPsd{kSlope * length, length}),
                                    Mirror{f_number * kAcross}, CircleAperture{kAcross}, kWave);
    };
    const GeneralisedHarveyShack reference = light(1e3 * kAcross);
    for (const double fraction : {0.3, 0.6}) {
      const double r = reference.encircled_energy_radius(fraction, 0);
      for (const double length : {30 * kAcross, 1e2 * kAcross, 1e5 * kAcross})
        EXPECT_NEAR(light(length).encircled_energy(r, 0), fraction, 1e-5) << f_number << ", " << length;
    }
  }
}

// The same of a power law whose lowest frequency is let go: 0.30 of the light fell to 0.16 on the way to no
// lowest frequency, where it is 0.28.
TEST(GhsPairs, ALowestFrequencyFarBelowTheApertureIsNone) {
  constexpr double kAcross = 0.2, kWave = 1e-6;
  const auto light = [&](double f_min) {
    PowerLawPsd psd;
    psd.exponent = 11.0 / 3;
    psd.amplitude = 2e-17;
    psd.f_min = f_min;
    psd.f_max = 1e4;
    return GeneralisedHarveyShack(RadialPsd(psd), Mirror{1.5 * kAcross}, CircleAperture{kAcross}, kWave);
  };
  const GeneralisedHarveyShack endless = light(0);
  double before = 1;
  for (const double fraction : {0.3, 0.6}) {
    const double r = endless.encircled_energy_radius(fraction, 0);
    // What is left out is tilt, of which a cut at f_min misses (f_min D)^(1/3).
    for (const double f_min : {1e-3, 1e-5, 1e-7, 1e-9}) {
      const double off = light(f_min / kAcross).encircled_energy(r, 0) - fraction;
      EXPECT_GT(off, -1e-6) << f_min;
      EXPECT_LT(off, 0.005 * std::cbrt(f_min)) << f_min;
      EXPECT_LT(off, before) << f_min;
      before = off;
    }
    before = 1;
  }
}

}  // namespace
}  // namespace aberfit
