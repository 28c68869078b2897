// Fast mirrors and steep slopes. Closed forms of theory are compared with exactly traced rays (law of
// reflection, PHYSICS 1), whose Gaussian slopes come from a lattice in four dimensions.
#include <gtest/gtest.h>

#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/theory/geometric_harvey_shack.h"
#include "edge.h"

namespace aberfit::test {
namespace {

constexpr double kFocal = 1;

struct Traced {
  double ee90 = 0, lost = 0;
};

// Rays of a parabola of diameter D with Gaussian slope errors, on a lattice of Korobov's kind (generalised
// golden ratio, Roberts 2018): relative error of ee90 below 1e-3 for 2^17 rays.
Traced traced(double diameter, double slope) {
  constexpr Eigen::Index kRays = 1 << 17;
  const Mirror mirror{.focal_length = kFocal};
  PupilSample pupil;
  SurfaceField field;
  for (Eigen::ArrayXd* part : {&pupil.x, &pupil.y, &pupil.weight}) part->resize(kRays);
  field.resize(kRays);
  field.height.setZero();
  constexpr double kPhi4 = 1.1673039782614187;  // root of x^5 = x + 1
  for (Eigen::Index i = 0; i < kRays; ++i) {
    double u[4];
    for (int k = 0; k < 4; ++k) {
      const double t = 0.5 + double(i + 1) * std::pow(kPhi4, -(k + 1));
      u[k] = std::min(std::max(t - std::floor(t), 1e-12), 1 - 1e-12);
    }
    const double rho = 0.5 * diameter * std::sqrt(u[0]), angle = 2 * std::numbers::pi * u[1];
    pupil.x[i] = rho * std::cos(angle), pupil.y[i] = rho * std::sin(angle);
    pupil.weight[i] = 1.0 / kRays;
    const double size = slope * std::sqrt(-2 * std::log(u[2])), towards = 2 * std::numbers::pi * u[3];
    field.slope_x[i] = size * std::cos(towards), field.slope_y[i] = size * std::sin(towards);
  }
  const RayBundle rays = trace(mirror, pupil, field);
  return {evaluate_exact({rays, rays, field.height}, {EncircledEnergyRadius{0.9, 0}}, 1)[0],
          double(rays.lost) / kRays};
}

constexpr double kSampling = 1e-3;  // of the lattice
// Near 45 degrees, at f/0.25, the radial spread slope/(1 - t^2) is no small angle. It changes the radius by 8
// slope, relative, and its long tail is sampled less well (4e-3 seen).
double promised(double f_number, double slope) {
  return f_number < 0.26 ? 5 * kSampling + 8 * slope : kSampling + 4.6 * slope * slope;
}

TEST(StabilityEdge, FastMirrors) {
  // The f-numbers go from 10 to 0.2. The avoided way is the paraxial radius. 45 degrees at the rim are
  // reached at f/0.25.
  Edge edge("fast_mirrors", "f-number [1]", "relative error of ee90 [1]");
  constexpr double kSlope = 1e-4;
  for (const double f_number :
       {10.0, 7.0, 5.0, 3.0, 2.0, 1.5, 1.0, 0.7, 0.5, 0.4, 0.35, 0.3, 0.27, 0.251, 0.25, 0.2}) {
    const double diameter = kFocal / f_number;
    EdgeRow row{f_number, std::nan(""), promised(f_number, kSlope), true};
    const double paraxial = 2.14596603 * 2 * kFocal * kSlope;
    try {
      const GeometricHarveyShack theory({.focal_length = kFocal}, CircleAperture{diameter, 0}, kSlope,
                                        Convention::kPhysical, 0);
      const double truth = traced(diameter, kSlope).ee90;
      row.told = false;
      row.error = std::abs(theory.encircled_energy_radius(0.9, 0) / truth - 1);
      row.avoided = std::abs(paraxial / truth - 1);
    } catch (const ComputationError&) {  // steeper than 45 degrees at the rim
    }
    edge.add(row);
  }
  edge.follows({"paraxial: 1/(32 N^2)", [](double n) { return 1 / (32 * n * n); }, 0.7, 3.5, 1.25});
  edge.expect();
}

TEST(StabilityEdge, SteepSlopes) {
  // The mirror is slow, so that the rest of the slope is the roughness; g2 = 1 loses a ray.
  Edge edge("steep_slopes", "RMS slope per axis [1]", "relative error of ee90 [1]");
  for (const double slope : geometric_steps(1e-3, 0.5, 14)) {
    const GeometricHarveyShack theory({.focal_length = kFocal}, CircleAperture{0.05, 0}, slope,
                                      Convention::kPhysical, 0);
    const Traced truth = traced(0.05, slope);
    edge.add({slope, std::abs(theory.encircled_energy_radius(0.9, 0) / truth.ee90 - 1),
              kSampling + 1.2 * 4.6 * slope * slope, truth.lost > 0});
  }
  edge.follows({"4.6 s^2", [](double s) { return 4.6 * s * s; }, 0.02, 0.12, 1.15});
  edge.expect();
}

}  // namespace
}  // namespace aberfit::test
