// Budgets as people write them: units, diameters, plate scale.
#include "aberfit/specify/budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace aberfit {
namespace {

constexpr double kArcsec = std::numbers::pi / 648000;

TEST(Budget, SaysStatisticLimitAndUnit) {
  const Budget sky = parse_budget("ee80_diameter", "<= 0.6 arcsec");
  EXPECT_EQ(std::get<EncircledEnergyRadius>(sky.statistic).fraction, 0.8);
  EXPECT_EQ(std::get<EncircledEnergyRadius>(sky.statistic).dz, 0);
  EXPECT_TRUE(sky.is_diameter && sky.at_most);
  EXPECT_EQ(sky.dimension, Dimension::kAngle);
  EXPECT_DOUBLE_EQ(sky.limit, 0.6 * kArcsec);
  EXPECT_EQ(budget_name(sky), "ee80_diameter_rad");
  // A radius of 3 um at f = 2 m is a diameter of 3 urad on the sky.
  EXPECT_DOUBLE_EQ(budgeted(sky, 3e-6, 2), 3e-6);
  EXPECT_EQ(in_budget_unit(sky, 0.25 * kArcsec), "0.25 arcsec");

  const Budget length = parse_budget("ee97.5_radius@-1.5 mm", ">=12um");
  EXPECT_DOUBLE_EQ(std::get<EncircledEnergyRadius>(length.statistic).fraction, 0.975);
  EXPECT_DOUBLE_EQ(std::get<EncircledEnergyRadius>(length.statistic).dz, -1.5e-3);
  EXPECT_FALSE(length.is_diameter || length.at_most);
  EXPECT_DOUBLE_EQ(length.limit, 12e-6);
  EXPECT_EQ(budgeted(length, 3e-6, 2), 3e-6);
  EXPECT_EQ(in_budget_unit(length, 3e-6), "3 um");
  EXPECT_EQ(budget_name(length), "ee97.5_radius_m@-1.5 mm");

  EXPECT_EQ(parse_budget("rms_height", "<= 20 nm").limit, 20e-9);
  EXPECT_EQ(parse_budget("scatter_rms", "<= 2 urad").dimension, Dimension::kAngle);
  EXPECT_EQ(budgeted(parse_budget("scatter_rms", "<= 2 urad"), 3e-6, 2), 3e-6) << "an angle already";
}

TEST(Budget, OfLightIsAShare) {
  const Budget hew = parse_budget("hew", "<= 5 arcsec");
  EXPECT_EQ(std::get<EncircledEnergyRadius>(hew.statistic).fraction, 0.5);
  EXPECT_TRUE(hew.is_diameter && !hew.of_light);
  EXPECT_EQ(budget_name(hew), "hew_rad");
  const Budget tis = parse_budget("tis", "<= 1 %");
  EXPECT_TRUE(std::holds_alternative<TotalScatter>(*tis.of_light));
  EXPECT_EQ(tis.limit, 0.01);
  EXPECT_EQ(in_budget_unit(tis, 0.0123), "1.23 %");
  EXPECT_EQ(budget_name(tis), "tis");
  const Budget strehl = parse_budget("strehl", ">= 0.8");
  EXPECT_TRUE(std::holds_alternative<StrehlRatio>(*strehl.of_light) && !strehl.at_most);
  EXPECT_EQ(in_budget_unit(strehl, 0.8), "0.8");
  const Budget mtf = parse_budget("mtf@20/mm", ">= 0.5");
  EXPECT_EQ(std::get<ModulationTransfer>(*mtf.of_light).frequency, 20e3);
  EXPECT_EQ(budget_name(mtf), "mtf@20/mm");
}

// A circle at f/500, where the rim scatters as the middle does, fine roughness: a core of exp(-g^2), a sharp
// step of the transfer function at 0, and the aperture's own (2/pi)(acos x - x sqrt(1 - x^2)).
TEST(Budget, OfLightHasItsClosedForms) {
  const double lambda = 500e-9, f = 100, radius = 0.1, rms = 20e-9;
  const double core = std::exp(-std::pow(4 * std::numbers::pi * rms / lambda, 2));
  const RadialPsd psd(UniformPsd{rms, 5000, 10000});
  const GhsPupil pupil({f, -1, {}}, CircleAperture{2 * radius}, lambda);
  const GeneralisedHarveyShack mean(psd, pupil);
  const auto value = [&](const LightProperty& what) { return LightProperties({what}, pupil)(mean)[0]; };
  EXPECT_NEAR(value(TotalScatter{}), 1 - core, 1e-6);
  EXPECT_NEAR(value(StrehlRatio{}), core, 3e-6);  // one in 1e6 of the scattered light is there
  const double cutoff = 2 * radius / (lambda * f), x = 0.3;
  const double aperture = 2 / std::numbers::pi * (std::acos(x) - x * std::sqrt(1 - x * x));
  EXPECT_NEAR(value(ModulationTransfer{x * cutoff}), aperture * core, 1e-5);
  EXPECT_NEAR(value(ModulationTransfer{0}), 1, 1e-9);
}

TEST(Budget, SaysWhatIsWrong) {
  const struct {
    const char *key, *bound, *said;
  } cases[] = {{"ee80", "<= 1 um", "is no budget"},
               {"ee100_radius", "<= 1 um", "is no budget"},
               {"ee80_width", "<= 1 um", "is no budget"},
               {"rms_height@1mm", "<= 1 um", "is no budget"},
               {"ee80_radius", "1 um", "<= or >="},
               {"ee80_radius", "< 1 um", "<= or >="},
               {"ee80_radius", "<= 1", "no unit"},
               {"ee80_radius", "<= 1 kg", "arcsec"},
               {"ee80_radius", "<= 0 um", "not above zero"},
               {"rms_height", "<= 1 arcsec", "nm"},
               {"scatter_rms", "<= 1 um", "arcsec"},
               {"strehl", ">= 1.2", "not below 1"},
               {"strehl", ">= 80 nm", "%"},
               {"mtf@20", ">= 0.5", "is no budget"},
               {"mtf", ">= 0.5", "is no budget"},
               {"tis", "<= 0", "not above zero"}};
  for (const auto& one : cases) {
    try {
      parse_budget(one.key, one.bound);
      ADD_FAILURE() << one.key << " " << one.bound;
    } catch (const UnitError& error) {
      EXPECT_NE(std::string(error.what()).find(one.said), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace aberfit
