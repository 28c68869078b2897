// Tests the position, value and height gradient of the highest irradiance.
#include "aberfit/waves/diffraction_peak.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <memory>
#include <numbers>

namespace aberfit {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFocal = 2.8, kDiameter = 0.4, kWave = 632.8e-9;

// Scatter whose mean spot is not used.
class GaussianScatter : public MeanScatter {
 public:
  Eigen::ArrayXd transfer(const Eigen::ArrayXd& shear) const override {
    return (-0.8 * (1 - (-(shear / 0.06).square()).exp())).exp();
  }
  Eigen::ArrayXd whole_transfer(const Eigen::ArrayXd& shear) const override {
    return Eigen::ArrayXd::Zero(shear.size());
  }
  double encircled_energy(double) const override { return 0; }
  double encircled_energy_slope(double) const override { return 0; }
  double irradiance() const override { return 0; }
  double image_transfer(double) const override { return 0; }
  double rms_height() const override { return 0; }
  double rms_slope_per_axis() const override { return 0; }
  double scatter_rms() const override { return 0; }
};

struct Scene {
  DiffractionPupil pupil;
  Eigen::ArrayXd x, y;
  explicit Scene(const Aperture& aperture = AnnulusAperture{kDiameter, 0.3 * kDiameter})
      : pupil(diffraction_pupil(aperture, kFocal, kDiameter / 40)),
        x(pupil.sample.x / (0.5 * kDiameter)),
        y(pupil.sample.y / (0.5 * kDiameter)) {}
  DiffractionProblem problem(bool scattered) const {
    DiffractionProblem result{pupil, kFocal, kWave};
    if (scattered) result.scatter = std::make_shared<GaussianScatter>();
    return result;
  }
  // Coma, astigmatism and an irregular term put the highest point off the axis.
  Eigen::ArrayXd height() const {
    return 130e-9 * (3 * (x.square() + y.square()) - 2) * x + 40e-9 * x * y + 25e-9 * (5 * x - 2 * y).sin();
  }
};

double strehl_of(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                 Eigen::ArrayXd* d_height = nullptr) {
  Eigen::VectorXd values;
  std::vector<Eigen::ArrayXd> gradients;
  EXPECT_TRUE(evaluate_diffraction(problem, height, {StrehlRatio{}}, 1, nullptr, &values,
                                   d_height ? &gradients : nullptr));
  if (d_height) *d_height = gradients[0];
  return values[0];
}

// Compares with the plain sum over cells, on a raster and on finer rasters about its best point.
TEST(DiffractionPeak, IsTheHighestOfThePattern) {
  for (const Aperture& aperture : std::vector<Aperture>{
           CircleAperture{kDiameter}, AnnulusAperture{kDiameter, 0.2}, RectangleAperture{kDiameter, 0.25}}) {
    const Scene scene(aperture);
    const Eigen::ArrayXd height = scene.height();
    const Eigen::ArrayXd px = scene.pupil.sample.x * scene.pupil.obliquity,
                         py = scene.pupil.sample.y * scene.pupil.obliquity;
    const double perfect = std::pow(scene.pupil.amplitude.sum(), 2);
    const auto irradiance = [&](double u, double v) {
      const Eigen::ArrayXd phase =
          4 * kPi / kWave * scene.pupil.obliquity * height + 2 * kPi / (kWave * kFocal) * (px * u + py * v);
      const double re = (scene.pupil.amplitude * phase.cos()).sum(),
                   im = (scene.pupil.amplitude * phase.sin()).sum();
      return (re * re + im * im) / perfect;
    };
    double x = 0, y = 0, top = 0;
    for (double step = 4e-6; step > 1e-10; step /= 8) {
      const double cx = x, cy = y;
      for (int i = -9; i <= 9; ++i)
        for (int j = -9; j <= 9; ++j)
          if (const double here = irradiance(cx + i * step, cy + j * step); here > top)
            top = here, x = cx + i * step, y = cy + j * step;
    }
    const DiffractionPeak peak = diffraction_peak(scene.problem(false), height);
    EXPECT_NEAR(peak.strehl, top, 1e-9);
    EXPECT_NEAR(peak.axis_ratio, irradiance(0, 0), 1e-9);
    EXPECT_GT(peak.strehl, peak.axis_ratio);
    EXPECT_NEAR(peak.x, x, 1e-8);
    EXPECT_NEAR(peak.y, y, 1e-8);
    EXPECT_NEAR(strehl_of(scene.problem(false), height), top, 1e-9);
  }
}

// A tilted telescope has the same image elsewhere.
TEST(DiffractionPeak, DoesNotKnowOfTilt) {
  const Scene scene;
  for (const bool scattered : {false, true}) {
    const DiffractionProblem problem = scene.problem(scattered);
    const DiffractionPeak plain = diffraction_peak(problem, scene.height());
    for (const double tilt : {1e-7, -3e-6, 8e-6}) {
      const Eigen::ArrayXd tilted = scene.height() - tilt * (scene.pupil.sample.x + 2 * scene.pupil.sample.y);
      const DiffractionPeak moved = diffraction_peak(problem, tilted);
      EXPECT_NEAR(moved.strehl, plain.strehl, 1e-9) << tilt;
      EXPECT_NEAR(moved.x - plain.x, 2 * kFocal * tilt, 1e-9) << tilt;
      EXPECT_NEAR(moved.y - plain.y, 4 * kFocal * tilt, 1e-9) << tilt;
    }
  }
}

// The highest point moves with the heights, but its value is stationary under this shift. Compares with
// central differences of the whole.
TEST(DiffractionPeak, HasTheGradientOfItsPlace) {
  const Scene scene;
  const Eigen::ArrayXd height = scene.height();
  const std::vector<Eigen::ArrayXd> ways = {scene.x, scene.x * (scene.x.square() + scene.y.square()),
                                            scene.x * scene.y, (7 * scene.y).cos()};
  for (const bool scattered : {false, true}) {
    const DiffractionProblem problem = scene.problem(scattered);
    Eigen::ArrayXd gradient;
    strehl_of(problem, height, &gradient);
    for (const Eigen::ArrayXd& way : ways) {
      constexpr double kStep = 2e-11;
      const double expected =
          (strehl_of(problem, height + kStep * way) - strehl_of(problem, height - kStep * way)) / (2 * kStep);
      EXPECT_NEAR((gradient * way).sum(), expected, 1e-6 * gradient.abs().sum());
    }
    EXPECT_NEAR((gradient * scene.pupil.sample.x).sum(), 0,
                1e-8 * (gradient * scene.pupil.sample.x).abs().sum());  // tilt
  }
}

// With scatter: the transform of lags times H, at the peak and around it.
TEST(DiffractionPeak, WithScatterIsTheHighestOfTheImage) {
  const Scene scene(CircleAperture{kDiameter});
  const DiffractionProblem problem = scene.problem(true);
  const DiffractionPeak peak = diffraction_peak(problem, scene.height());
  const PsfImage image = diffraction_psf(problem, scene.height(), {12e-6, 0.1e-6, 0});
  const PsfImage perfect =
      diffraction_psf(scene.problem(false), Eigen::ArrayXd::Zero(scene.x.size()), {1e-6, 0.1e-6, 0});
  EXPECT_NEAR(image.intensity.maxCoeff() / perfect.intensity.maxCoeff(), peak.strehl, 1e-3 * peak.strehl);
  EXPECT_LE(image.intensity.maxCoeff() / perfect.intensity.maxCoeff(), peak.strehl * (1 + 1e-9));
}

}  // namespace
}  // namespace aberfit
