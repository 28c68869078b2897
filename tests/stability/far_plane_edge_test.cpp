// Planes far out of the focus of a fast mirror. The mean spot by wave theory is compared with the diffraction
// integral of a perfect annulus, which is one Hankel transform per plane.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/bessel.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "edge.h"

namespace aberfit::test {
namespace {

constexpr double kLambda = 633e-9, kFocal = 1, kRim = 0.2, kInner = 0.075;  // f/2.5
constexpr double kPi = std::numbers::pi;
constexpr int kRadii = 20;

double sine_of(double rho) { return rho / kFocal / (1 + std::pow(rho / (2 * kFocal), 2)); }

// E at 0.06 to 1.2 times the radius of the geometric spot. P = f sin(angle), amplitude 2/((1 + c) sqrt(c)),
// phase k dz' (1 - c) (PHYSICS 6). parabolic: phase and amplitude of the paraxial focus, as near the axis.
Eigen::ArrayXd encircled(double dz, bool parabolic = false) {
  const double inner = kFocal * sine_of(kInner), outer = kFocal * sine_of(kRim), k = 2 * kPi / kLambda;
  const double turn = k * dz * (1 - std::sqrt(1 - outer * outer));
  const Quadrature pupil = gauss_legendre(300 + int(turn), inner, outer);
  const Eigen::ArrayXd c = (1 - pupil.nodes.array().square()).sqrt();
  const Eigen::ArrayXd path = parabolic ? 0.5 * pupil.nodes.array().square() : Eigen::ArrayXd(1 - c);
  const Eigen::ArrayXd even =
      parabolic ? Eigen::ArrayXd::Ones(c.size()) : Eigen::ArrayXd(2 / ((1 + c) * c.sqrt()));
  const Eigen::ArrayXd phase = k * dz / (1 + dz / kFocal) * path;
  const Eigen::ArrayXd amplitude = even * pupil.weights.array() * pupil.nodes.array();
  const double all = (even * amplitude).sum();
  const Eigen::ArrayXd real = amplitude * phase.cos(), imaginary = amplitude * phase.sin();
  const double cone = dz * kRim / kFocal;
  Eigen::ArrayXd result(kRadii), j0(c.size()), j1(c.size());
  double sum = 0;
  for (int ring = 0; ring < kRadii; ++ring) {
    const Quadrature radii = gauss_legendre(24 + int(turn) / 6, 0.06 * ring * cone, 0.06 * (ring + 1) * cone);
    for (Eigen::Index i = 0; i < radii.nodes.size(); ++i) {
      const double v = k * radii.nodes[i] / (kFocal + dz);
      const Eigen::ArrayXd z = v * pupil.nodes.array();
      bessel_j0_j1(z.data(), int(z.size()), j0.data(), j1.data());
      const double intensity = std::pow((real * j0).sum(), 2) + std::pow((imaginary * j0).sum(), 2);
      sum += radii.weights[i] * intensity * v * k / (kFocal + dz) / all;
    }
    result[ring] = sum;
  }
  return result;
}

TEST(StabilityEdge, FarPlanes) {
  // The avoided way is the parabolic phase alone. Up to 1500 rad across the overlap the program uses its
  // integral, beyond that the light of rings (PupilLight).
  Edge edge("far_planes", "phase from axis to rim [rad]", "error of encircled energy [1]");
  const GeneralisedHarveyShack light(RadialPsd(GaussianPsd{1e-13, 0.01}), Mirror{kFocal, -1, {}},
                                     AnnulusAperture{2 * kRim, 2 * kInner}, kLambda);
  const double rim = sine_of(kRim);
  for (const double phase : {20.0, 60.0, 200.0, 600.0, 1300.0, 1700.0, 2500.0}) {
    const double dz = phase * kLambda * kFocal * kFocal / (kPi * kRim * kRim);
    const Eigen::ArrayXd truth = encircled(dz);
    const MeanSpot spot = light.at_plane(dz);
    EdgeRow row{phase, 0, phase < 1000 ? 1e-5 : 5e-5};
    row.avoided = (encircled(dz, true) - truth).abs().maxCoeff();
    for (int ring = 0; ring < kRadii; ++ring)
      row.error = std::max(
          row.error, std::abs(spot.encircled_energy(0.06 * (ring + 1) * dz * kRim / kFocal) - truth[ring]));
    edge.add(row);
  }
  edge.follows({"parabolic: 1.1 (D/2f)^2", [=](double) { return 1.1 * rim * rim; }, 60, 3000, 1.4});
  edge.expect();
}

}  // namespace
}  // namespace aberfit::test
