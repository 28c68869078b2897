// Warnings name the reason why a statistic by waves is missing, here on a grid of 32 cells.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "aberfit/forward/forward_model.h"

namespace aberfit {
namespace {

constexpr double kFocal = 2.8, kDiameter = 0.4, kWavelength = 632.8e-9;
constexpr int kCells = 32;

struct Scene {
  Mirror mirror{kFocal, -1, {}};
  Aperture aperture = CircleAperture{kDiameter};
  PupilSample pupil = diffraction_pupil(aperture, kFocal, kDiameter / kCells).sample;
  SurfaceOperator surface{terms(), pupil, focus_operator(FocusModel::kWaves, 1)};

  static TermSet terms() {
    TermSet terms;
    terms.radius = kDiameter / 2;
    terms.zernike = zernike_modes(2, 4);
    return terms;
  }
  LightPath path() const {
    return {mirror, pupil, surface, FocusModel::kWaves, kWavelength, &aperture, Centre::kNominal};
  }
  /// height: of each term [m].
  Warnings warnings(const std::vector<Statistic>& statistics, double height = 20e-9) const {
    Warnings found;
    const Eigen::VectorXd coefficients = Eigen::VectorXd::Constant(surface.terms().size(), height);
    focus_statistics(path(), coefficients, statistics, 1, &found);
    return found;
  }
};

TEST(WaveWarnings, RmsRadiusOfWavesDiverges) {
  const Scene scene;
  const Warnings found = scene.warnings({RmsRadius{}});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "rms-radius-of-waves");
  EXPECT_NE(found[0].message.find("second moment diverges"), std::string::npos) << found[0].message;
  EXPECT_TRUE(scene.warnings({EncircledEnergyRadius{0.5, 0}}).empty());
}

// The field of view of a grid ends at lambda f / (2 pitch), 16 grains lambda f / D here.
TEST(WaveWarnings, StatisticMissingBeyondTheFieldOfView) {
  const Scene scene;
  const double grain = kWavelength * kFocal / kDiameter;
  const Warnings found = scene.warnings({RingThrough{1.2 * kCells / 2 * grain, 0}});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "statistic-missing");
  EXPECT_NE(found[0].message.find("field of view"), std::string::npos) << found[0].message;
  EXPECT_NE(found[0].message.find("ee_within"), std::string::npos) << found[0].message;
  EXPECT_TRUE(scene.warnings({RingThrough{0.8 * kCells / 2 * grain, 0}}).empty());
}

// The scatter of a perfect mirror is 0, where the root of a sum of squares has no derivative. A fit gets a
// warning, although a value exists.
TEST(WaveWarnings, StatisticMissingWhereTheSurfaceMovesNoRay) {
  const Scene scene;
  const auto model = make_forward_model(scene.path(), {ScatterRms{}}, 1);
  Eigen::VectorXd values;
  model->move_to(Eigen::VectorXd::Zero(scene.surface.terms().size()));
  EXPECT_FALSE(model->evaluate(1e-6, &values));
  EXPECT_NE(model->trouble().find("does not move a ray"), std::string::npos) << model->trouble();
  model->move_to(Eigen::VectorXd::Constant(scene.surface.terms().size(), 20e-9));
  EXPECT_TRUE(model->evaluate(1e-6, &values));
  EXPECT_EQ(model->trouble(), "");
  EXPECT_TRUE(scene.warnings({ScatterRms{}}, 0).empty());

  const Warnings found = scene.warnings({ScatterRms{}}, std::nan(""));
  EXPECT_TRUE(std::any_of(found.begin(), found.end(), [](const Warning& warning) {
    return warning.code == "statistic-missing" && warning.message.find("scatter_rms") == 0;
  }));
}

// A grid that is fine enough for the focus may be too coarse for the defocus of another plane. The warning
// names that plane, not the field of view of the focus.
TEST(WaveWarnings, TheReasonIsThatOfThePlaneThatHasNoPattern) {
  const Scene scene;
  const double grain = kWavelength * kFocal / kDiameter, depth = 8 * grain * kFocal / kDiameter;
  const Warnings found =
      scene.warnings({EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.5, -20 * depth}});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "psf-aliased");
  EXPECT_NE(found[0].message.find("for the plane -"), std::string::npos) << found[0].message;
  EXPECT_NE(found[0].message.find("out of focus"), std::string::npos) << found[0].message;
  EXPECT_TRUE(scene.warnings({EncircledEnergyRadius{0.5, -0.5 * depth}}).empty());
}

}  // namespace
}  // namespace aberfit
