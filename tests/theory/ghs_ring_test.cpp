// Through-focus widths of mirrors that have aberrations: theory's against those of a diffraction grid.
#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/forward/forward_model.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "lommel.h"

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

// The peak of N(z) lies where the aberrations put it, not in the paraxial focus: half of what the ring holds
// there made theory's width up to a quarter of it wrong.
TEST(GhsRing, WidthIsBetweenTheHalvesOfThePeakWhereverItLies) {
  const Aperture circle = CircleAperture{kDiameter}, annulus = AnnulusAperture{kDiameter, 0.08};
  // Light's path is 0.29 waves off at the rim.
  const Mirror conic{kFocal, -0.9};
  for (const double share : {0.5, 0.8}) {
    const RingFwhm ring{share, {}};
    for (const Aperture& aperture : {circle, annulus}) {
      SCOPED_TRACE(testing::Message() << share << " " << aperture.index());
      EXPECT_NEAR(by_theory(conic, aperture, ring) / on_grid(conic, aperture, ring), 1, 3e-3);
    }
    const Mirror turned = with_zernikes(60e-9, 40e-9, -30e-9);
    SCOPED_TRACE(share);
    EXPECT_NEAR(by_theory(turned, circle, ring) / on_grid(turned, circle, ring), 1, 3e-3);
    // Nothing moves without them.
    EXPECT_NEAR(by_theory(Mirror{kFocal}, circle, ring) / on_grid(Mirror{kFocal}, circle, ring), 1, 3e-3);
  }
}

// N(z) of a perfect mirror.
class ByLommel {
 public:
  ByLommel(double radius, double focal_length, double wavelength, double ring)
      : a_(radius), f_(focal_length), wavelength_(wavelength), ring_(ring) {}
  double share(double dz) const { return test::light_by_lommel(a_, f_, wavelength_, ring_, dz); }
  double peak(double nearest) const {
    double low = nearest, high = -nearest;  // one peak between
    while (high - low > 1e-5 * f_) {
      const double left = low + (high - low) / 3, right = high - (high - low) / 3;
      (share(left) < share(right) ? low : high) = share(left) < share(right) ? left : right;
    }
    return 0.5 * (low + high);
  }
  double crossing(double peak, double outside) const {
    const double half = 0.5 * share(peak);
    for (double inside = peak;;) {
      const double middle = 0.5 * (inside + outside);
      if (std::abs(outside - inside) < 1e-7 * f_) return middle;
      (share(middle) > half ? inside : outside) = middle;
    }
  }

 private:
  double a_, f_, wavelength_, ring_;
};

// Half of what the ring holds in focus made widths of a quarter of the focal length 0.6 % too large.
TEST(GhsRing, ADeepFocusHasItsPeakNearerToTheMirror) {
  constexpr double kLength = 0.15, kInfrared = 4.75e-6, kAcross = 4e-3;
  const RadialPsd none(UniformPsd{1e-6 * kInfrared, 1000, 5000});
  const GeneralisedHarveyShack light(none, Mirror{kLength}, CircleAperture{kAcross}, kInfrared);
  for (const double ring : {70e-6, 130e-6}) {
    const ByLommel truth(0.5 * kAcross, kLength, kInfrared, ring);
    const double peak = truth.peak(-0.02), lower = truth.crossing(peak, -0.07),
                 upper = truth.crossing(peak, 0.07);
    const GeneralisedHarveyShack::RingPlanes planes = light.ring_planes(ring);
    EXPECT_LT(peak, -1e-3) << ring;
    EXPECT_NEAR(planes.peak, peak, 2e-3 * (upper - lower)) << ring;
    EXPECT_NEAR(light.ring_fwhm(ring) / (upper - lower), 1, 5e-4) << ring;
    EXPECT_EQ(planes.upper - planes.lower, light.ring_fwhm(ring));
  }
}

// Of its own N(z), which others are compared with elsewhere; a rectangle's planes cost seconds.
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
