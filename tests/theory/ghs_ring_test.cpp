// Through-focus widths of mirrors with aberrations: theory against a diffraction grid.
#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/forward/forward_model.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "lommel.h"
#include "short_form.h"

namespace aberfit {
namespace {

constexpr double kFocal = 1.2, kDiameter = 0.2, kWavelength = 632.8e-9;
constexpr int kCells = 256;

double by_theory(const Mirror& mirror, const Aperture& aperture, const RingFwhm& ring) {
  const RadialPsd none(UniformPsd{1e-6 * kWavelength, 10, 50});
  return GeneralisedHarveyShack(none, mirror, aperture, kWavelength)(ring);
}

double on_grid(const Mirror& mirror, const Aperture& aperture, const RingFwhm& ring) {
  TermSet flat;
  flat.radius = kDiameter / 2;
  flat.zernike = zernike_modes(2, 2);
  const PupilSample pupil = diffraction_pupil(aperture, kFocal, kDiameter / kCells).sample;
  const SurfaceOperator surface(flat, pupil, focus_operator(FocusModel::kWaves, 2));
  const LightPath path{mirror, pupil, surface, FocusModel::kWaves, kWavelength, &aperture, Centre::kNominal};
  return focus_statistics(path, Eigen::VectorXd::Zero(flat.size()), {ring}, 2, nullptr)[0];
}

Mirror with_zernikes(double defocus, double coma, double spherical) {
  Mirror mirror{kFocal};
  mirror.zernike = {{{2, 0}, defocus}, {{3, -1}, coma}, {{4, 0}, spherical}};
  mirror.zernike_radius = kDiameter / 2;
  return mirror;
}

// The peak of N(z) lies where the aberrations put it, not in the paraxial focus.
TEST_WITH_SHORT_FORM(GhsRing, WidthIsBetweenTheHalvesOfThePeakWhereverItLies) {
  const Aperture circle = CircleAperture{kDiameter}, annulus = AnnulusAperture{kDiameter, 0.08};
  // The path differs by 0.29 waves at the rim.
  const Mirror conic{kFocal, -0.9};
  for (const double share : aberfit::test::all_or_few(whole, std::vector{0.5, 0.8}, {1})) {
    const RingFwhm ring{share, {}};
    for (const Aperture& aperture : {circle, annulus}) {
      SCOPED_TRACE(testing::Message() << share << " " << aperture.index());
      EXPECT_NEAR(by_theory(conic, aperture, ring) / on_grid(conic, aperture, ring), 1, 3e-3);
    }
    const Mirror turned = with_zernikes(60e-9, 40e-9, -30e-9);
    SCOPED_TRACE(share);
    EXPECT_NEAR(by_theory(turned, circle, ring) / on_grid(turned, circle, ring), 1, 3e-3);
    // Without aberrations nothing moves.
    EXPECT_NEAR(by_theory(Mirror{kFocal}, circle, ring) / on_grid(Mirror{kFocal}, circle, ring), 1, 3e-3);
  }
}

// N(z) of a perfect mirror, sampled in 200 planes.
class ByLommel {
 public:
  ByLommel(double radius, double focal_length, double wavelength, double ring, double inner = 0)
      : a_(radius), f_(focal_length), wavelength_(wavelength), ring_(ring), inner_(inner) {}
  double share(double dz) const { return test::light_by_lommel(a_, f_, wavelength_, ring_, dz, inner_); }
  double peak(double within) const {
    double top = 0, most = 0;
    const double pitch = within / 100;
    for (int k = -100; k <= 100; ++k)
      if (const double here = share(k * pitch); here > most) most = here, top = k * pitch;
    double low = top - pitch, high = top + pitch;
    while (high - low > 1e-5 * pitch) {
      const double left = low + (high - low) / 3, right = high - (high - low) / 3;
      (share(left) < share(right) ? low : high) = share(left) < share(right) ? left : right;
    }
    return 0.5 * (low + high);
  }
  double crossing(double peak, double outside) const {
    const double half = 0.5 * share(peak);
    for (double inside = peak;;) {
      const double middle = 0.5 * (inside + outside);
      if (std::abs(outside - inside) < 1e-8 * std::abs(outside - peak)) return middle;
      (share(middle) > half ? inside : outside) = middle;
    }
  }
  double width(double outside) const {
    const double top = peak(0.5 * outside);
    return crossing(top, outside) - crossing(top, -outside);
  }

 private:
  double a_, f_, wavelength_, ring_, inner_;
};

// The peak is not in the focus: half of the value in focus would make widths of f/4 wrong by 0.6 %.
TEST(GhsRing, ADeepFocusHasItsPeakNearerToTheMirror) {
  constexpr double kLength = 0.15, kInfrared = 4.75e-6, kAcross = 4e-3;
  const RadialPsd none(UniformPsd{1e-6 * kInfrared, 1000, 5000});
  const GeneralisedHarveyShack light(none, Mirror{kLength}, CircleAperture{kAcross}, kInfrared);
  for (const double ring : {70e-6, 130e-6}) {
    const ByLommel truth(0.5 * kAcross, kLength, kInfrared, ring);
    const double peak = truth.peak(0.02), lower = truth.crossing(peak, -0.07),
                 upper = truth.crossing(peak, 0.07);
    const GeneralisedHarveyShack::RingPlanes planes = light.ring_planes(ring);
    EXPECT_LT(peak, -1e-3) << ring;
    EXPECT_NEAR(planes.peak, peak, 2e-3 * (upper - lower)) << ring;
    EXPECT_NEAR(light.ring_fwhm(ring) / (upper - lower), 1, 5e-4) << ring;
    EXPECT_EQ(planes.upper - planes.lower, light.ring_fwhm(ring));
  }
}

// Where a ring of an annulus is dark, the focus lies between two peaks. Half of the focal value would make
// widths wrong by 0.6 %.
TEST_WITH_SHORT_FORM(GhsRing, OfAnAnnulusThePeakIsTheHigherOfTwo) {
  constexpr double kAcross = 0.1, kGreen = 550e-9;
  const RadialPsd none(UniformPsd{1e-7 * kGreen, 100, 500});
  struct Case {
    double inner, v;  // k a ring/f
  };
  const std::vector<Case> cases{Case{0.0, 6.2}, Case{0.3, 9.9}, Case{0.4, 13.3}, Case{0.5, 16.1},
                                Case{0.6, 19.6}};
  for (const double focal : aberfit::test::all_or_few(whole, std::vector{20.0, 200.0}, {0}))
    for (const Case& of : aberfit::test::all_or_few(whole, cases, {2, 4})) {
      const double ring = of.v * kGreen * focal / (kPi * kAcross);
      const Aperture aperture = of.inner > 0 ? Aperture(AnnulusAperture{kAcross, of.inner * kAcross})
                                             : Aperture(CircleAperture{kAcross});
      const GeneralisedHarveyShack light(none, Mirror{focal}, aperture, kGreen);
      const double width = light.ring_fwhm(ring);
      EXPECT_NEAR(width / ByLommel(0.5 * kAcross, focal, kGreen, ring, of.inner).width(width), 1, 2e-6)
          << of.inner << " f " << focal;
    }
}

// The peak must be continuous in the ring radius; a search that stops at the top of its first parabola jumps.
TEST(GhsRing, ThePeakOfADeepFocusMovesWithTheRing) {
  constexpr double kLength = 0.15, kInfrared = 4.75e-6, kAcross = 3e-3;
  const RadialPsd none(UniformPsd{1e-6 * kInfrared, 1000, 5000});
  const GeneralisedHarveyShack light(none, Mirror{kLength}, CircleAperture{kAcross}, kInfrared);
  double last = 0;
  for (double v = 1.3; v < 1.7; v *= 1.002) {
    const GeneralisedHarveyShack::RingPlanes planes =
        light.ring_planes(v * kInfrared * kLength / (kPi * kAcross));
    const double off = planes.peak / (planes.upper - planes.lower);
    if (last != 0) {
      EXPECT_NEAR(off / last, 1, 4e-3) << v;
    }
    last = off;
  }
}

// Compares the width with the model's own N(z); a rectangle's planes take seconds.
TEST(GhsRing, WidthIsBetweenTheHalvesOfWhatTheRingHoldsMost) {
  constexpr double kLength = 0.15, kInfrared = 4.75e-6;
  const RadialPsd rough(UniformPsd{0.05 * kInfrared, 1000, 3000});
  for (const Aperture& aperture :
       {Aperture(CircleAperture{4e-3}), Aperture(RectangleAperture{4.5e-3, 2.7e-3})}) {
    const GeneralisedHarveyShack light(rough, Mirror{kLength}, aperture, kInfrared);
    const double ring = light.encircled_energy_radius(0.5, 0);
    const GeneralisedHarveyShack::RingPlanes planes = light.ring_planes(ring);
    const double step = 0.02 * (planes.upper - planes.lower),
                 most = light.encircled_energy(ring, planes.peak);
    for (const double side : {-1.0, 1.0})
      EXPECT_GT(most, light.encircled_energy(ring, planes.peak + side * step)) << aperture.index();
    for (const double end : {planes.lower, planes.upper})
      EXPECT_NEAR(light.encircled_energy(ring, end) / most, 0.5, 1e-5) << aperture.index();
  }
}

}  // namespace
}  // namespace aberfit
