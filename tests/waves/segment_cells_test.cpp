// Compares the grid cells of separate segments with closed forms and with those of the undivided aperture.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/scene/segments.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {
namespace {

constexpr double kLambda = 1e-6;

Eigen::VectorXd of(const DiffractionPupil& pupil, double focal_length, const Eigen::ArrayXd& height,
                   const std::vector<Statistic>& statistics) {
  const DiffractionProblem problem{pupil, focal_length, kLambda};
  Eigen::VectorXd values;
  evaluate_diffraction(problem, height, statistics, 1, nullptr, &values, nullptr);
  return values;
}

// The heights of two halves of a square differ by d. With 37 cells the middle row belongs to both halves. On
// the axis the field is cos(2 pi d/lambda) of the total.
TEST(SegmentCells, OfTwoHalvesInterfereByTheirStep) {
  const double f = 200;
  SegmentedAperture halves{
      {{{-0.1, -0.1}, {0, -0.1}, {0, 0.1}, {-0.1, 0.1}}, {{0, -0.1}, {0.1, -0.1}, {0.1, 0.1}, {0, 0.1}}}, 0};
  halves.piston = 1e-9;
  const DiffractionPupil pupil = diffraction_pupil(halves, f, 0.2 / 37);
  EXPECT_EQ(pupil.cover.size(), 37 * 38);
  for (const double step : {0.0, 0.1, 0.25, 0.4}) {
    Eigen::ArrayXd height(pupil.cover.size());
    for (Eigen::Index k = 0; k < height.size(); ++k)
      height[k] = pupil.sample.segment[std::size_t(k)] == 0 ? 0 : step * kLambda;
    const double wanted = std::pow(std::cos(2 * std::numbers::pi * step), 2);
    double re = 0, im = 0;
    for (Eigen::Index k = 0; k < height.size(); ++k) {
      const double phase = 4 * std::numbers::pi / kLambda * height[k];
      re += pupil.amplitude[k] * std::cos(phase);
      im += pupil.amplitude[k] * std::sin(phase);
    }
    EXPECT_NEAR((re * re + im * im) / (pupil.total * pupil.total), wanted, 1e-6) << step;
  }
}

// With zero heights, cells of segments and cells of the whole are the same aperture, in focus and out.
TEST(SegmentCells, InTheirPlacesAreOneAperture) {
  const double f = 3;
  SegmentedAperture whole =
      obstructed(hexagonal_segments(2, 0.2, 0.004, true, 0.2), {{0.02, 0.4, 0}, {0.02, 0.5, 0}});
  SegmentedAperture apart = whole;
  apart.piston = 1e-9;
  for (const double dz : {0.0, 2e-5})
    for (const std::array<double, 2> shift : {std::array{0.0, 0.0}, {0.25, -0.35}}) {
      const std::vector<Statistic> wanted{EncircledEnergyRadius{0.3, dz}, EncircledEnergyRadius{0.8, dz}};
      const DiffractionPupil one = diffraction_pupil(whole, f, 0.01, shift),
                             many = diffraction_pupil(apart, f, 0.01, shift);
      EXPECT_GT(many.cover.size(), one.cover.size());
      EXPECT_DOUBLE_EQ(many.total, one.total);
      const Eigen::VectorXd of_one = of(one, f, Eigen::ArrayXd::Zero(one.cover.size()), wanted),
                            of_many = of(many, f, Eigen::ArrayXd::Zero(many.cover.size()), wanted);
      for (Eigen::Index k = 0; k < of_one.size(); ++k)
        EXPECT_NEAR(of_many[k] / of_one[k], 1, 5e-5) << dz << ' ' << shift[0];
    }
}

// One half of a square is tilted by more than lambda/D, which moves its image by 2 f times the slope.
TEST(SegmentCells, TiltTheirOwnLight) {
  const double f = 200, slope = 8e-5;
  SegmentedAperture halves{
      {{{-0.1, -0.1}, {0, -0.1}, {0, 0.1}, {-0.1, 0.1}}, {{0, -0.1}, {0.1, -0.1}, {0.1, 0.1}, {0, 0.1}}}, 0};
  halves.tip_tilt = 1e-9;
  const DiffractionPupil pupil = diffraction_pupil(halves, f, 0.2 / 200);
  Eigen::ArrayXd height = Eigen::ArrayXd::Zero(pupil.cover.size());
  for (Eigen::Index k = 0; k < height.size(); ++k)
    if (pupil.sample.segment[std::size_t(k)] == 1) height[k] = slope * (pupil.sample.x[k] - 0.05);
  // Half of the energy is near the axis, the other half 32 mm from it.
  const Eigen::VectorXd inside =
      of(pupil, f, height, {EncircledEnergyRadius{0.45, 0}, EncircledEnergyRadius{0.6, 0}});
  EXPECT_LT(inside[0], 0.3 * 2 * f * slope);
  EXPECT_NEAR(inside[1], 2 * f * slope, 0.2 * 2 * f * slope);
}

}  // namespace
}  // namespace aberfit
