// A plane wave of the surface on a pupil grid that is too coarse for it. The truth is a phase grating: order
// q has J_q(beta)^2 of the energy (Goodman, Introduction to Fourier Optics, 4.4.4), as an Airy pattern at q
// lambda f_focal f.
#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <numbers>

#include "aberfit/forward/forward_model.h"
#include "edge.h"

namespace aberfit::test {
namespace {

constexpr double kFocal = 2.8, kDiameter = 0.4, kWavelength = 632.8e-9, kPhase = 0.5;  // beta [rad]
constexpr int kCells = 128;

TEST(StabilityEdge, WavesOfTheSurfaceOnCoarseGrids) {
  // A ring half way to the orders +-1 holds the energy of order 0, J_0(beta)^2. Airy wings change it: those
  // of order 0 outside and those of +-1 inside have 1/(pi^2 cycles across) each, 1.2 % at 16.
  Edge edge("wave_grid", "cycles of the surface per cell of the grid [1]",
            "error of the light inside a ring [1]");
  const double pitch = kDiameter / kCells;
  const Mirror mirror{.focal_length = kFocal};
  const Aperture aperture = CircleAperture{kDiameter};
  const PupilSample pupil = diffraction_pupil(aperture, kFocal, pitch).sample;
  for (const double cycles : {0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.49, 0.55, 0.6, 0.7, 0.8, 0.9}) {
    TermSet terms;
    terms.radius = kDiameter / 2;
    terms.fourier = {{cycles / pitch, 0}};
    const double height = kPhase * kWavelength / (4 * std::numbers::pi);
    const SurfaceOperator surface(terms, pupil, focus_operator(FocusModel::kWaves, 1));
    const LightPath path{mirror,      pupil,     surface,         FocusModel::kWaves,
                         kWavelength, &aperture, Centre::kNominal};
    // If the wave is aliased, it looks longer, and its diffraction orders lie inside this radius.
    const double ring = std::min(0.5 * cycles, 0.45) * kWavelength * kFocal / pitch;
    Warnings warnings;
    const double found =
        focus_statistics(path, Eigen::Vector2d(height, 0), {RingThrough{ring, 0}}, 1, &warnings)[0];
    const double truth = std::pow(boost::math::cyl_bessel_j(0, kPhase), 2);
    bool told = false;
    for (const Warning& warning : warnings) told = told || warning.code == "terms-undersampled";
    edge.add({cycles, std::abs(found - truth), 0.5 / (cycles * kCells), told});
  }
  edge.expect();
}

TEST(StabilityEdge, RaysOnCoarseGrids) {
  // Rays in rows and columns see a wave of one cycle per step, or two points per cycle, at one phase. The
  // truth is the closed RMS radius, 2 f_focal times the RMS slope 2 pi f a/sqrt(2), for small angles.
  Edge edge("ray_grid", "cycles of the surface per step of the grid [1]",
            "relative error of the RMS radius [1]");
  const Mirror mirror{.focal_length = kFocal};
  const PupilSample pupil =
      make_pupil(RectangleAperture{kDiameter, kDiameter, 0}, {PupilLayout::kGrid, kCells * kCells, 1});
  const auto& grid = std::get<CartesianGrid>(pupil.structure);
  const double pitch = grid.x[1] - grid.x[0], height = 1e-9;
  for (const double cycles : {0.1, 0.2, 0.3, 0.4, 0.45, 0.5, 0.6, 0.75, 0.9, 1.0, 1.5, 2.0}) {
    TermSet terms;
    terms.radius = kDiameter;
    terms.fourier = {{cycles / pitch, 0}};
    const SurfaceOperator surface(terms, pupil, focus_operator(FocusModel::kRays, 1));
    const LightPath path{mirror, pupil, surface};
    Warnings warnings;
    // A sine, because the grid is symmetric about the axis, half a step off it.
    const double found = focus_statistics(path, Eigen::Vector2d(0, height), {RmsRadius{0}}, 1, &warnings)[0];
    const double slope = 2 * std::numbers::pi * cycles / pitch * height / std::sqrt(2);
    bool told = false;
    for (const Warning& warning : warnings) told = told || warning.code == "terms-undersampled";
    // Error: t^2/2 at f/5 and the ends of the rows, one part in 128.
    edge.add({cycles, std::abs(found / (2 * kFocal * slope) - 1), 0.02, told});
  }
  edge.expect();
}

}  // namespace
}  // namespace aberfit::test
