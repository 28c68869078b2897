// Budgets as people write them: units, diameters, plate scale.
#include "aberfit/specify/budget.h"

#include <gtest/gtest.h>

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

TEST(Budget, SaysWhatIsWrong) {
  const struct {
    const char *key, *bound, *said;
  } cases[] = {{"ee80", "<= 1 um", "is no budget"},          {"ee100_radius", "<= 1 um", "is no budget"},
               {"ee80_width", "<= 1 um", "is no budget"},    {"rms_height@1mm", "<= 1 um", "is no budget"},
               {"ee80_radius", "1 um", "<= or >="},          {"ee80_radius", "< 1 um", "<= or >="},
               {"ee80_radius", "<= 1", "no unit"},           {"ee80_radius", "<= 1 kg", "arcsec"},
               {"ee80_radius", "<= 0 um", "not above zero"}, {"rms_height", "<= 1 arcsec", "nm"},
               {"scatter_rms", "<= 1 um", "arcsec"}};
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
