#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/waves/diffraction_psf.h"
#include "aberfit/waves/transfer_image.h"

namespace aberfit {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFocal = 2.8, kDiameter = 0.4, kWave = 632.8e-9;
constexpr double kAiryUnit = kWave * kFocal / kDiameter;

double at(const PsfImage& image, double x, double y) {
  const auto index = [&](double v) { return Eigen::Index(std::lround((v - image.first) / image.pitch)); };
  return image.intensity(index(y), index(x));
}

class DiffractionImage : public testing::Test {
 protected:
  DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / 63);
  DiffractionProblem problem{pupil, kFocal, kWave};
  Eigen::ArrayXd flat = Eigen::ArrayXd::Zero(pupil.cover.size());
  Eigen::ArrayXd rough = 60e-9 * (25 * pupil.sample.x + 3).sin() * (31 * pupil.sample.y).cos();
};

TEST_F(DiffractionImage, HoldsAllEnergyThatTheFieldOfViewHolds) {
  for (const double pitch : {0.0, 0.9 * kAiryUnit}) {
    const PsfImage image = diffraction_psf(problem, rough, {0, pitch, 3e-4});
    EXPECT_EQ(image.method, PsfImage::Method::kTransform);
    const double outside = check_diffraction(problem, rough, 3e-4).energy_outside;
    EXPECT_NEAR(image.intensity.sum() * image.pitch * image.pitch, 1 - outside, 1e-12);
  }
}

TEST_F(DiffractionImage, PixelsSumToTheEncircledEnergyOfTheTransferFunction) {
  // Counting pixels has an error of the order of the rim's pixels, here 1e-3 of the energy.
  const PsfImage image = diffraction_psf(problem, rough, {8 * kAiryUnit, kAiryUnit / 40, 0});
  const double radius = 3.3 * kAiryUnit;
  double sum = 0;
  for (Eigen::Index row = 0; row < image.intensity.rows(); ++row)
    for (Eigen::Index column = 0; column < image.intensity.cols(); ++column)
      if (std::hypot(image.first + double(row) * image.pitch, image.first + double(column) * image.pitch) <
          radius)
        sum += image.intensity(row, column) * image.pitch * image.pitch;
  EXPECT_NEAR(sum, diffraction_encircled_energy(problem, rough, 0, Eigen::ArrayXd::Constant(1, radius))[0],
              1e-3);
}

TEST_F(DiffractionImage, PixelsAreIntegralsOfThePattern) {
  // Simpson's rule over 16 x 16 steps per pixel, with an error of 3e-5 of the brightest pixel.
  constexpr int kPixels = 9, kSteps = 16;
  const double half = 3 * kAiryUnit, pixel = 2 * half / kPixels, dz = -3e-4;
  const Eigen::ArrayXXd pixels = diffraction_pixels(problem, rough, dz, half, kPixels);
  const PsfImage image = diffraction_psf(problem, rough, {half * (1 + 1e-9), pixel / kSteps, dz});
  ASSERT_EQ(image.intensity.rows(), kPixels * kSteps + 1);
  const auto weight = [](int k) { return (k == 0 || k == kSteps ? 1.0 : k % 2 == 1 ? 4.0 : 2.0) / 3; };
  for (int row = 0; row < kPixels; ++row)
    for (int column = 0; column < kPixels; ++column) {
      double sum = 0;
      for (int j = 0; j <= kSteps; ++j)
        for (int i = 0; i <= kSteps; ++i)
          sum += weight(i) * weight(j) * image.intensity(row * kSteps + j, column * kSteps + i);
      EXPECT_NEAR(pixels(row, column), sum * image.pitch * image.pitch, 5e-5 * pixels.maxCoeff())
          << row << ' ' << column;
    }
}

TEST_F(DiffractionImage, PixelsHoldTheFieldOfViewAndNothingBeyond) {
  const DiffractionCheck check = check_diffraction(problem, rough, 3e-4);
  for (const int pixels : {1, 2, 7, 64}) {
    const double half = 0.8 * check.field_of_view;
    const Eigen::ArrayXXd image = diffraction_pixels(problem, rough, 3e-4, half, pixels);
    EXPECT_NEAR(image.sum(), 1 - check.energy_outside, 1e-12);
    const double pixel = 2 * half / pixels;
    for (int row = 0; row < pixels; ++row)
      if (std::abs((row + 0.5) * pixel - half) - 0.5 * pixel > 0.5 * check.field_of_view) {
        EXPECT_TRUE((image.row(row) == 0).all() && (image.col(row) == 0).all());
      }
  }
}

TEST_F(DiffractionImage, TransformAndMatrixAgree) {
  const PsfImage whole = diffraction_psf(problem, rough, {0, 0, -2e-4});
  const PsfImage part = diffraction_psf(problem, rough, {5 * whole.pitch, whole.pitch, -2e-4});
  EXPECT_EQ(part.method, PsfImage::Method::kMatrix);
  ASSERT_EQ(part.intensity.rows(), 11);
  const double peak = whole.intensity.maxCoeff();
  for (int row = -5; row <= 5; ++row)
    for (int column = -5; column <= 5; ++column)
      EXPECT_NEAR(at(part, column * whole.pitch, row * whole.pitch),
                  at(whole, column * whole.pitch, row * whole.pitch), 1e-12 * peak);
}

TEST_F(DiffractionImage, RefusesMoreSamplesThanFitInMemory) {
  const double field = check_diffraction(problem, flat, 0).field_of_view;
  for (const double pitch : {field / 17000, field / 1e10, 1e-300, 5e-324}) {
    EXPECT_THROW(diffraction_psf(problem, flat, {0, pitch, 0}), ComputationError) << pitch;
    EXPECT_THROW(diffraction_psf(problem, flat, {0.4 * field, std::min(pitch, field / 50000), 0}),
                 ComputationError)
        << pitch;
  }
  // A window of few samples needs no transform of the whole field, even with a fine pitch.
  const double pitch = field / 1e12;
  const PsfImage image = diffraction_psf(problem, flat, {2 * pitch, pitch, 0});
  EXPECT_EQ(image.method, PsfImage::Method::kMatrix);
  ASSERT_EQ(image.intensity.rows(), 5);
  const double peak = diffraction_psf(problem, flat, {1e-6, 1e-6, 0}).intensity(1, 1);
  for (int k = 0; k < 25; ++k) EXPECT_NEAR(image.intensity(k / 5, k % 5) / peak, 1, 1e-12);
}

TEST_F(DiffractionImage, TiltShiftsThePsfAsItShiftsRays) {
  const double pitch = kAiryUnit / 4, p = 3 * pitch / (2 * kFocal), q = -2 * pitch / (2 * kFocal);
  const PsfWindow window{8 * pitch, pitch, 0};
  const PsfImage still = diffraction_psf(problem, rough, window);
  const PsfImage moved = diffraction_psf(problem, rough + p * pupil.sample.x + q * pupil.sample.y, window);
  for (int row = -4; row <= 4; ++row)
    for (int column = -4; column <= 4; ++column)  // X = -2 p f, Y = -2 q f
      EXPECT_NEAR(at(moved, (column - 3) * pitch, (row + 2) * pitch), at(still, column * pitch, row * pitch),
                  1e-11 * still.intensity.maxCoeff());
}

TEST_F(DiffractionImage, AxialIntensityFollowsSincSquaredWithItsZeroAtEightLambdaFSquared) {
  const double f_number = kFocal / kDiameter,
               peak = kPi * kDiameter * kDiameter / 4 / std::pow(kWave * kFocal, 2);
  EXPECT_NEAR(diffraction_psf(problem, flat, {1e-6, 1e-6, 0}).intensity(1, 1) / peak, 1, 1e-12);
  for (const double share : {-0.6, 0.25, 0.5, 1.5}) {
    const double dz = share * 8 * kWave * f_number * f_number;
    // u/4 = pi R^2 dz/(2 lambda f (f+dz)); the paraxial 8 lambda F^2 holds to dz/f = 1e-4.
    const double t = kPi * kDiameter * kDiameter * dz / (8 * kWave * kFocal * (kFocal + dz));
    const double expected = peak * std::pow(std::sin(t) / t * kFocal / (kFocal + dz), 2);
    EXPECT_NEAR(diffraction_psf(problem, flat, {1e-6, 1e-6, dz}).intensity(1, 1) / peak, expected / peak,
                2e-5)
        << share;
  }
  EXPECT_LT(diffraction_psf(problem, flat, {1e-6, 1e-6, 8 * kWave * f_number * f_number}).intensity(1, 1),
            1e-7 * peak);
}

TEST_F(DiffractionImage, SinusoidalGratingSendsBesselSquaredIntoItsOrders) {
  // The aperture has 12 whole periods, so every order is a sinc whose zeros are the other orders. The
  // irradiance at n lambda f nu is J_n(4 pi a/lambda)^2 of the unaberrated peak (Goodman 4.4.4). With 16
  // cells per period, order n + 16 falls there too: 2 J_4 J_12 = 4e-12 at most.
  const double width = 0.24, nu = 12 / width, a = 80e-9;
  const DiffractionPupil square = diffraction_pupil(RectangleAperture{width, width}, kParaxial, width / 192);
  DiffractionPupil plain = square;
  plain.amplitude = plain.cover;  // with equal cells the discrete sum is exact
  const DiffractionProblem grating{plain, kFocal, kWave};
  const Eigen::ArrayXd height = a * (2 * kPi * nu * square.sample.x).sin();
  const double order = kWave * kFocal * nu, peak = std::pow(width / (kWave * kFocal), 2);
  const PsfImage image = diffraction_psf(grating, height, {4.5 * order, order / 2, 0});
  const PsfImage corrected = diffraction_psf({square, kFocal, kWave}, height, {4.5 * order, order / 2, 0});
  for (int n = -4; n <= 4; ++n) {
    const double expected = std::pow(boost::math::cyl_bessel_j(n, 4 * kPi * a / kWave), 2);
    EXPECT_NEAR(at(image, n * order, 0) / peak, expected, 1e-11) << n;
    EXPECT_NEAR(at(corrected, n * order, 0) / peak, expected, 1e-3)
        << n;  // the corrected edge is not a whole period
  }
}

}  // namespace
}  // namespace aberfit
