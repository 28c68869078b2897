// Mean spots of rough mirrors against the double integral over all pairs of aperture points, with the
// coherence at their own positions. The theory uses only the midpoint and the shear of a pair, to the second
// order in the shear. Fast mirrors with few cycles across are the hardest case.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "short_form.h"

namespace aberfit {
namespace {

/// A point of a parabola: P = f sin(theta), position, q = 1/(1 + t^2) = cos^2(theta/2) (PHYSICS 6).
struct MirrorPoint {
  double pupil, place, q;
};
double apart2(double one, double two, double cosine) {
  return one * one + two * two - 2 * one * two * cosine;
}

/// Mean of exp(i (phase - phase)) for two points at an angle of this cosine about the axis.
using Coherence = std::function<double(const MirrorPoint&, const MirrorPoint&, double cosine)>;

// Gaussian autocorrelation, k = 4 pi/lambda.
Coherence of_gaussian(double k, double rms, double length) {
  return [=](const MirrorPoint& a, const MirrorPoint& b, double cosine) {
    const double alike = std::exp(-apart2(a.place, b.place, cosine) / (length * length));
    return std::exp(-0.5 * std::pow(k * rms, 2) * (a.q * a.q + b.q * b.q - 2 * a.q * b.q * alike));
  };
}

// A mirror with a random tilt of this deviation in either axis: phase k q (s . r) = k (s . P).
Coherence of_tilts(double k, double slope) {
  return [=](const MirrorPoint& a, const MirrorPoint& b, double cosine) {
    return std::exp(-0.5 * std::pow(k * slope, 2) * apart2(a.pupil, b.pupil, cosine));
  };
}

// Even illumination of the mirror, c = cos(theta).
class LightByPairs {
 public:
  LightByPairs(double f, double radius, double inner, double wavelength, const Coherence& coherence)
      : f_(f), wavelength_(wavelength) {
    const auto pupil = [&](double r) { return r / (1 + r * r / (4 * f * f)); };
    const Quadrature radial = gauss_legendre(kRadial, pupil(inner), pupil(radius));
    std::vector<MirrorPoint> points;
    std::vector<double> weight;
    double all = 0;
    for (int i = 0; i < kRadial; ++i) {
      const double p = radial.nodes[i], c = std::sqrt(1 - std::pow(p / f, 2)), t2 = (1 - c) / (1 + c);
      const double amplitude = 2 / ((1 + c) * std::sqrt(c)), area = 2 * kPi * p * radial.weights[i];
      points.push_back({p, 2 * f * std::sqrt(t2), 1 / (1 + t2)});
      weight.push_back(amplitude * area);
      versine_.push_back(1 - c);
      all += amplitude * amplitude * area;
    }
    for (std::size_t i = 0; i < kRadial; ++i)
      for (std::size_t j = 0; j < kRadial; ++j)
        for (int a = 0; a < kAngles; ++a) {
          const double cosine = std::cos(kPi * (a + 0.5) / kAngles);
          pairs_.push_back({std::sqrt(apart2(points[i].pupil, points[j].pupil, cosine)),
                            weight[i] * weight[j] * coherence(points[i], points[j], cosine) / (kAngles * all),
                            versine_[i] - versine_[j]});
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

TEST_WITH_SHORT_FORM(GhsPairs, MeanSpotsOfFastMirrorsAreThoseOfAllPairsOfPoints) {
  constexpr double kAcross = 0.2, kWave = 1e-6;
  struct Case {
    double f_number, inner, rms, length, off;
  };
  const std::vector<Case> cases{
      Case{2, 0, 0.35 * kWave, 0.03, 3e-5},    Case{1.5, 0.5, 0.05 * kWave, 0.05, 3e-5},
      Case{1, 0, 0.2 * kWave, 0.04, 3e-5},     Case{1, 0.4, 0.2 * kWave, 0.04, 3e-5},
      Case{1, 0, 0.05 * kWave, 0.05, 1.2e-4},  Case{1, 0, 0.08 * kWave, 0.05, 1.2e-4},
      Case{1, 0, 0.12 * kWave, 0.08, 1.2e-4},  Case{0.75, 0, 0.08 * kWave, 0.05, 4e-4},
      Case{0.5, 0, 0.08 * kWave, 0.05, 1.3e-3}};
  for (const Case& of : aberfit::test::all_or_few(whole, cases, {1, 2})) {
    const double f = of.f_number * kAcross;
    const Aperture aperture = of.inner > 0 ? Aperture(AnnulusAperture{kAcross, of.inner * kAcross})
                                           : Aperture(CircleAperture{kAcross});
    const GeneralisedHarveyShack light(RadialPsd(GaussianPsd{of.rms, of.length}), Mirror{f}, aperture, kWave);
    const LightByPairs truth(f, 0.5 * kAcross, 0.5 * of.inner * kAcross, kWave,
                             of_gaussian(4 * kPi / kWave, of.rms, of.length));
    double worst = 0;
    for (const double fraction : {0.25, 0.5, 0.68, 0.8}) {
      const double r = light.encircled_energy_radius(fraction, 0), depth = 2 * of.f_number * r;
      for (const double dz : {0.0, 0.5 * depth, -depth})
        worst = std::max(worst, std::abs(light.encircled_energy(r, dz) - truth.encircled_energy(r, dz)));
    }
    EXPECT_LT(worst, of.off) << "f/" << of.f_number << ", inner " << of.inner << ", rms " << of.rms;
  }
}

// Waves much longer than the aperture only tilt it: the spot depends on their slopes, not on heights.
TEST_WITH_SHORT_FORM(GhsPairs, WavesLongerThanTheApertureTiltIt) {
  constexpr double kAcross = 0.2, kWave = 1e-6, kSlope = 4e-6;
  for (const double f_number : aberfit::test::all_or_few(whole, std::vector{1.0, 1.5, 3.0}, {0})) {
    const double f = f_number * kAcross;
    const LightByPairs tilted(f, 0.5 * kAcross, 0, kWave, of_tilts(4 * kPi / kWave, kSlope));
    for (const double apertures : aberfit::test::all_or_few(whole, std::vector{1e2, 1e3, 1e5}, {0, 2})) {
      const double length = apertures * kAcross;  // slope per axis sqrt2 rms/length
      const GeneralisedHarveyShack light(
          RadialPsd(GaussianPsd{kSlope * length / std::numbers::sqrt2, length}), Mirror{f},
          CircleAperture{kAcross}, kWave);
      for (const double fraction : {0.3, 0.6, 0.8}) {
        const double r = light.encircled_energy_radius(fraction, 0);
        EXPECT_NEAR(tilted.encircled_energy(r, 0), fraction, f_number < 1.5 ? 6e-5 : 2e-5)
            << "f/" << f_number << ", " << apertures;
      }
    }
  }
}

// The lowest frequency of a power law goes to 0: the tilts left out fall as (f_min D)^(1/3).
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
  for (const double fraction : {0.3, 0.6}) {
    const double r = endless.encircled_energy_radius(fraction, 0);
    double before = 1;
    for (const double f_min : {1e-3, 1e-5, 1e-7, 1e-9}) {
      const double off = light(f_min / kAcross).encircled_energy(r, 0) - fraction;
      EXPECT_GT(off, -1e-6) << f_min;
      EXPECT_LT(off, 0.005 * std::cbrt(f_min)) << f_min;
      EXPECT_LT(off, before) << f_min;
      before = off;
    }
  }
}

}  // namespace
}  // namespace aberfit
