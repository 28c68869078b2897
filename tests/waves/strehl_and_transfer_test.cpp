// Tests Strehl ratio and transfer function of a surface against closed forms, a sum over image pixels, and
// with roughness that is not part of the heights.
#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <memory>
#include <numbers>

#include "aberfit/waves/diffraction_peak.h"
#include "aberfit/waves/diffraction_psf.h"
#include "aberfit/waves/transfer_image.h"

namespace aberfit {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFocal = 2.8, kDiameter = 0.4, kWave = 632.8e-9;
constexpr double kCutoff = kDiameter / (kWave * kFocal);  // cutoff of the image [cycles/m]

Eigen::VectorXd values_of(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                          const std::vector<Statistic>& statistics) {
  Eigen::VectorXd values;
  EXPECT_TRUE(evaluate_diffraction(problem, height, statistics, 1, nullptr, &values, nullptr));
  return values;
}

// Goodman, Introduction to Fourier Optics, 6.31.
double circle_otf(double s) { return s < 1 ? 2 / kPi * (std::acos(s) - s * std::sqrt(1 - s * s)) : 0; }

// Born & Wolf 8.8: the axial value is (sin(phi/2)/(phi/2))^2, phi the phase of defocus at the rim.
TEST(StrehlAndTransfer, OfDefocusIsTheClosedForm) {
  const DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / 128);
  const Eigen::ArrayXd rho2 =
      (pupil.sample.x.square() + pupil.sample.y.square()) / (0.25 * kDiameter * kDiameter);
  for (const double nanometres : {0.0, 20.0, 80.0, 240.0}) {
    const double half = 2 * kPi * nanometres * 1e-9 / kWave;
    const Eigen::VectorXd strehl =
        values_of({pupil, kFocal, kWave}, nanometres * 1e-9 * rho2, {StrehlRatio{}});
    EXPECT_NEAR(strehl[0], half == 0 ? 1 : std::pow(std::sin(half) / half, 2), 1e-6) << nanometres;
  }
}

TEST(StrehlAndTransfer, OfAPerfectCircleIsGoodmans) {
  for (const int cells : {64, 127}) {
    const DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / cells);
    const Eigen::ArrayXd flat = Eigen::ArrayXd::Zero(pupil.cover.size());
    double worst = 0;
    for (const double part : {0.02, 0.05, 0.123, 0.25, 0.5, 0.77, 0.98})
      worst = std::max(
          worst, std::abs(values_of({pupil, kFocal, kWave}, flat, {ModulationTransfer{part * kCutoff}})[0] -
                          circle_otf(part)));
    EXPECT_LT(worst, 3e-4) << cells;  // from energy beyond the field of view
    RecordProperty("worst_" + std::to_string(cells), std::to_string(worst));
  }
}

struct Bench {
  DiffractionPupil pupil =
      diffraction_pupil(AnnulusAperture{kDiameter, 0.3 * kDiameter}, kFocal, kDiameter / 48);
  Eigen::ArrayXd height;
  Bench() {
    const Eigen::ArrayXd x = pupil.sample.x / (0.5 * kDiameter), y = pupil.sample.y / (0.5 * kDiameter);
    height = 60e-9 * (x * x - y * y) + 40e-9 * (3 * x * y * y - x * x * x) + 30e-9 * (5 * x).sin();
  }
};

// Compares with the image: axial and highest irradiance, and its Fourier transform with the kernel J0.
TEST(StrehlAndTransfer, AreThoseOfTheImage) {
  const Bench bench;
  const DiffractionProblem problem{bench.pupil, kFocal, kWave};
  const PsfImage image = diffraction_psf(problem, bench.height, {});
  const PsfImage perfect = diffraction_psf(problem, Eigen::ArrayXd::Zero(bench.height.size()), {4e-5});
  const auto middle = [](const PsfImage& of) {
    const auto at = Eigen::Index(std::lround(-of.first / of.pitch));
    EXPECT_NEAR(of.first + double(at) * of.pitch, 0, 1e-9 * of.pitch);
    return of.intensity(at, at);
  };
  EXPECT_NEAR(diffraction_peak(problem, bench.height).axis_ratio, middle(image) / middle(perfect), 1e-10);
  const double strehl = values_of(problem, bench.height, {StrehlRatio{}})[0];
  EXPECT_GE(strehl, image.intensity.maxCoeff() / middle(perfect));
  EXPECT_NEAR(strehl, image.intensity.maxCoeff() / middle(perfect), 0.02);  // the peak lies between samples
  for (const double part : {0.05, 0.2, 0.45, 0.8}) {
    double sum = 0;
    const double end = 0.5 * kWave * kFocal / bench.pupil.pitch_x;
    for (Eigen::Index row = 0; row < image.intensity.rows(); ++row)
      for (Eigen::Index column = 0; column < image.intensity.cols(); ++column) {
        const double r =
            std::hypot(image.first + double(row) * image.pitch, image.first + double(column) * image.pitch);
        if (r < end)
          sum += image.intensity(row, column) * boost::math::cyl_bessel_j(0, 2 * kPi * part * kCutoff * r);
      }
    EXPECT_NEAR(values_of(problem, bench.height, {ModulationTransfer{part * kCutoff}})[0],
                std::abs(sum) * image.pitch * image.pitch, 2e-5)
        << part;
  }
}

// For a rotationally symmetric image the orientation of the square does not matter. The reference is the
// transfer function summed over all lags with the sinc of both sides.
TEST(StrehlAndTransfer, LightInASquareIsTheSumOverTheLags) {
  const DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / 64);
  const Eigen::ArrayXd rho2 =
      (pupil.sample.x.square() + pupil.sample.y.square()) / (0.25 * kDiameter * kDiameter);
  const Eigen::ArrayXd height = 90e-9 * rho2 - 150e-9 * rho2.square();
  const DiffractionProblem problem{pupil, kFocal, kWave};
  for (const double dz : {0.0, 3e-4}) {
    const TransferImage otf = diffraction_transfer(problem, height, dz, 1000);
    const auto sinc = [](double x) { return x == 0 ? 1 : std::sin(kPi * x) / (kPi * x); };
    for (const double side : {3e-6, 9e-6, 40e-6}) {
      double sum = 0;
      for (Eigen::Index row = 0; row < otf.value.rows(); ++row)
        for (Eigen::Index column = 0; column < otf.value.cols(); ++column)
          sum += otf.value(row, column).real() * sinc(side * otf.step * double(row - otf.middle)) *
                 sinc(side * otf.step * double(column - otf.middle));
      sum *= std::pow(side * otf.step, 2);
      // Energy that aliases into the field of view is not rotationally symmetric.
      const double folded = 1.5e-4 * std::pow(side / 40e-6, 2);
      EXPECT_NEAR(values_of(problem, height, {EnsquaredThrough{side, dz}})[0], sum, folded)
          << side << " " << dz;
    }
  }
}

// Only a mean spot: the part that the grid represents must be subtracted to the last bit.
class AllOfIt : public MeanScatter {
 public:
  Eigen::ArrayXd transfer(const Eigen::ArrayXd& shear) const override { return (-8 * shear).exp(); }
  Eigen::ArrayXd whole_transfer(const Eigen::ArrayXd& shear) const override { return transfer(shear); }
  double encircled_energy(double) const override { return 0; }
  double encircled_energy_slope(double) const override { return 0; }
  double irradiance() const override { return 1.7e9; }
  double image_transfer(double frequency) const override { return std::exp(-frequency / 5e4); }
  double rms_height() const override { return 0; }
  double rms_slope_per_axis() const override { return 0; }
  double scatter_rms() const override { return 0; }
};

TEST(StrehlAndTransfer, OfScatterAloneAreThoseOfTheMeanSpot) {
  const Bench bench;
  DiffractionProblem problem{bench.pupil, kFocal, kWave};
  problem.scatter = std::make_shared<AllOfIt>();
  const Eigen::VectorXd values =
      values_of(problem, Eigen::ArrayXd::Zero(bench.height.size()), {StrehlRatio{}, ModulationTransfer{3e4}});
  // Axial irradiance of the perfect parabola: (int A)^2/(lambda f)^2 / int A^2; paraxially area/(lambda f)^2.
  const double area = kPi / 4 * kDiameter * kDiameter * (1 - 0.09);
  EXPECT_NEAR(values[0], 1.7e9 / (area / std::pow(kWave * kFocal, 2)), 1e-2 * values[0]);
  EXPECT_NEAR(values[1], std::exp(-0.6), 1e-9);
}

// Frequencies beyond the cutoff have zero transfer, so a fit near the cutoff needs no exception.
TEST(StrehlAndTransfer, BeyondTheCutoffThereIsNoTransfer) {
  const Bench bench;
  const DiffractionProblem problem{bench.pupil, kFocal, kWave};
  for (const double part : {1.001, 1.2, 5.0})
    EXPECT_LT(values_of(problem, bench.height, {ModulationTransfer{part * kCutoff}})[0], 1e-4) << part;
  Eigen::VectorXd values;
  EXPECT_FALSE(
      evaluate_diffraction(problem, bench.height, {ModulationTransfer{-1}}, 1, nullptr, &values, nullptr));
  EXPECT_TRUE(std::isnan(values[0]));
}

}  // namespace
}  // namespace aberfit
