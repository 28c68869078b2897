// Through-focus widths of mirrors that have aberrations: theory's against those of a diffraction grid.
#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/forward/forward_model.h"
#include "aberfit/theory/generalised_harvey_shack.h"

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

}  // namespace
}  // namespace aberfit
