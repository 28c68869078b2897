// Tests the transfer function on its grid of lags: Goodman's formula for a circle, the factor of scatter, and
// the lags that are kept when there are many.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/waves/transfer_image.h"

namespace aberfit {
namespace {

constexpr double kFocalLength = 28, kRadius = 0.2, kWavelength = 632.8e-9;

// H = exp(-x/10 cm) for the transfer function; the tests use nothing else.
class ExponentialScatter : public MeanScatter {
 public:
  Eigen::ArrayXd transfer(const Eigen::ArrayXd& shear) const override { return (-10 * shear).exp(); }
  Eigen::ArrayXd whole_transfer(const Eigen::ArrayXd& shear) const override { return transfer(shear); }
  double encircled_energy(double) const override { return std::nan(""); }
  double encircled_energy_slope(double) const override { return std::nan(""); }
  double irradiance() const override { return std::nan(""); }
  double image_transfer(double) const override { return std::nan(""); }
  double rms_height() const override { return 0; }
  double rms_slope_per_axis() const override { return 0; }
  double scatter_rms() const override { return 0; }
};

// Goodman, Introduction to Fourier Optics, 6.31.
double circle_otf(double shear) {
  const double s = shear / (2 * kRadius);
  return s < 1 ? 2 / std::numbers::pi * (std::acos(s) - s * std::sqrt(1 - s * s)) : 0;
}

double shear_of(const TransferImage& otf, Eigen::Index row, Eigen::Index column) {
  return kWavelength * kFocalLength * otf.step *
         std::hypot(double(row - otf.middle), double(column - otf.middle));
}

TEST(DiffractionTransfer, OfACircleIsGoodmansTimesThatOfTheScatter) {
  const DiffractionPupil pupil =
      diffraction_pupil(CircleAperture{2 * kRadius, 0}, kParaxial, 2 * kRadius / 96);
  const Eigen::ArrayXd flat = Eigen::ArrayXd::Zero(pupil.sample.size());
  DiffractionProblem problem{pupil, kFocalLength, kWavelength};
  const TransferImage plain = diffraction_transfer(problem, flat, 0, 1000);
  problem.scatter = std::make_shared<ExponentialScatter>();
  const TransferImage scattered = diffraction_transfer(problem, flat, 0, 1000);
  ASSERT_EQ(plain.value.rows(), 2 * plain.middle + 1);
  double worst = 0;
  for (Eigen::Index row = 0; row < plain.value.rows(); ++row)
    for (Eigen::Index column = 0; column < plain.value.cols(); ++column) {
      const double shear = shear_of(plain, row, column);
      worst = std::max(worst, std::abs(plain.value(row, column) - circle_otf(shear)));
      EXPECT_LT(std::abs(scattered.value(row, column) - plain.value(row, column) * std::exp(-10 * shear)),
                1e-13);
    }
  EXPECT_LT(worst, 5e-4);  // corners of edge cells, for 96 cells across
  RecordProperty("worst", std::to_string(worst));
  EXPECT_NEAR(shear_of(plain, plain.middle, 2 * plain.middle), 2 * kRadius, 3 * 2 * kRadius / 96);
}

TEST(DiffractionTransfer, OfManyLagsTakesEverySecondOrThird) {
  const DiffractionPupil pupil =
      diffraction_pupil(CircleAperture{2 * kRadius, 0}, kFocalLength, 2 * kRadius / 64);
  const Eigen::ArrayXd height = 3e-8 * (20 * pupil.sample.x).sin();
  const DiffractionProblem problem{pupil, kFocalLength, kWavelength};
  const TransferImage all = diffraction_transfer(problem, height, 1e-3, 1000);
  for (const int most : {40, 25}) {
    const TransferImage some = diffraction_transfer(problem, height, 1e-3, most);
    const auto every = Eigen::Index(std::lround(some.step / all.step));
    EXPECT_EQ(every, most == 40 ? 2 : 3);
    ASSERT_EQ(some.middle, all.middle / every);
    for (Eigen::Index k = 0; k < some.value.rows(); ++k)
      for (Eigen::Index j = 0; j < some.value.cols(); ++j)
        EXPECT_EQ(some.value(k, j),
                  all.value(all.middle + every * (k - some.middle), all.middle + every * (j - some.middle)));
  }
  EXPECT_THROW(diffraction_transfer(problem, height, -2 * kFocalLength, 40), ComputationError);
}

}  // namespace
}  // namespace aberfit
