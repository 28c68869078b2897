#include "aberfit/focus/statistic.h"

#include <gtest/gtest.h>

using namespace aberfit;

TEST(StatisticName, CarriesFractionAndSiUnit) {
  EXPECT_EQ(statistic_name(EncircledEnergyRadius{0.5, 0.0}), "ee50_radius_m");
  EXPECT_EQ(statistic_name(EncircledEnergyRadius{0.9, 0.0}), "ee90_radius_m");
  EXPECT_EQ(statistic_name(EncircledEnergyRadius{0.975, 0.0}), "ee97.5_radius_m");
  EXPECT_EQ(statistic_name(EncircledEnergyRadius{1.0 / 3.0, 0.0}), "ee33.3333_radius_m");
  EXPECT_EQ(statistic_name(EncircledEnergyRadius{0.1, 0.0}), "ee10_radius_m");
}

TEST(StatisticName, HidesTheRoundingOfPercentages) {
  // In binary, 100 * 0.29 = 28.999999999999996 and 100 * 0.07 = 7.000000000000001.
  for (int percent = 1; percent < 100; ++percent)
    EXPECT_EQ(statistic_name(EncircledEnergyRadius{percent / 100.0, 0.0}),
              "ee" + std::to_string(percent) + "_radius_m");
}

TEST(StatisticName, NamesPlanesInMillimetresAndTheFocusNotAtAll) {
  EXPECT_EQ(statistic_name(EncircledEnergyRadius{0.5, -1e-3}), "ee50_radius_m@-1mm");
  EXPECT_EQ(statistic_name(EncircledEnergyRadius{0.5, 5e-4}), "ee50_radius_m@0.5mm");
  EXPECT_EQ(statistic_name(EncircledEnergyRadius{0.5, 0.010}), "ee50_radius_m@10mm");
  EXPECT_EQ(statistic_name(EncircledEnergyRadius{0.5, -0.0}), "ee50_radius_m");
  EXPECT_EQ(statistic_name(RmsRadius{0.0}), "rms_radius_m");
  EXPECT_EQ(statistic_name(RmsRadius{2.5e-3}), "rms_radius_m@2.5mm");
  EXPECT_EQ(statistic_name(RingThrough{76e-6, 5e-4, true}), "ring_through@0.5mm");
  EXPECT_EQ(statistic_name(RingThrough{76e-6, 0.0, true}), "ring_through");
  EXPECT_EQ(statistic_name(RingThrough{76e-6, 5e-4}), "ee_within_76um@0.5mm");
  EXPECT_EQ(statistic_name(RingThrough{7.25e-6, 0.0}), "ee_within_7.25um");
}

TEST(StatisticName, KeepsSixSignificantDigitsOfAPlane) {
  EXPECT_EQ(statistic_name(RmsRadius{1.23456789e-3}), "rms_radius_m@1.23457mm");
  EXPECT_EQ(statistic_name(RmsRadius{-0.12345678}), "rms_radius_m@-123.457mm");
  EXPECT_EQ(statistic_name(RmsRadius{1.5e-8}), "rms_radius_m@0.000015mm");
  EXPECT_EQ(statistic_name(RmsRadius{1234.5678}), "rms_radius_m@1234570mm");
  EXPECT_EQ(statistic_name(RmsRadius{0.1 * 3e-3}), "rms_radius_m@0.3mm");  // 0.30000000000000004 mm
  EXPECT_EQ(statistic_name(RmsRadius{9.9999999e-3}), "rms_radius_m@10mm");
}

TEST(StatisticName, SaysTheRingUnlessItIsTheDefault) {
  EXPECT_EQ(statistic_name(RingFwhm{}), "ring_fwhm_m");
  EXPECT_EQ(statistic_name(RingFwhm{0.9, {}}), "ring_fwhm_m");
  EXPECT_EQ(statistic_name(RingFwhm{0.5, {}}), "ring_fwhm_m@ring=ee50");
  EXPECT_EQ(statistic_name(RingFwhm{0.9, 76e-6}), "ring_fwhm_m@ring=76um");
  EXPECT_EQ(statistic_name(RingFwhm{0.5, 1.25e-5}), "ring_fwhm_m@ring=12.5um");
}

TEST(StatisticKind, IsFoundByItsKeyAndByItsStatistic) {
  for (const std::string& key : request_keys()) EXPECT_EQ(kind_of_key(key).key, key);
  EXPECT_EQ(&kind_of_key("ee50"), &kind_of(EncircledEnergyRadius{}));
  EXPECT_EQ(&kind_of_key("ee97.5"), &kind_of(EncircledEnergyRadius{0.5, 1e-3}));
  EXPECT_EQ(&kind_of_key("ee_within"), &kind_of(RingThrough{}));
  for (const char* none : {"", "ee", "eel", "pssn", "ring_profile"})
    EXPECT_THROW(kind_of_key(none), std::invalid_argument) << none;
  EXPECT_FALSE(kind_of(RmsRadius{}).in_waves());
  EXPECT_FALSE(kind_of(StrehlRatio{}).in_rays() || kind_of(ModulationTransfer{}).in_rays());
  EXPECT_TRUE(is_share(StrehlRatio{}) && is_share(ModulationTransfer{}) && is_share(RingThrough{}));
  EXPECT_FALSE(is_share(RingThrough{1e-6, 0, true}) || is_share(EncircledEnergyRadius{}));
  EXPECT_TRUE(kind_of(RmsHeight{}).is_moment() && kind_of(ScatterRms{}).is_moment());
}

TEST(StatisticKind, DimensionAndNameAgree) {
  for (const Statistic& statistic :
       {Statistic(EncircledEnergyRadius{0.5, -1e-3}), Statistic(RingFwhm{0.5, {}}), Statistic(ScatterRms{}),
        Statistic(ScatterMean{}), Statistic(SpotFwhm{}), Statistic(RmsRadius{1e-3}), Statistic(RmsHeight{})})
    EXPECT_EQ(dimension_of_name(statistic_name(statistic)), kind_of(statistic).dimension)
        << statistic_name(statistic);
  EXPECT_EQ(dimension_of_name("ee_within_10um@0.5mm"), Dimension::kNumber);
  EXPECT_EQ(dimension_of_name("ring_fwhm_m@ring=ee50#2"), Dimension::kLength);
  EXPECT_EQ(name_without_unit("ee50_radius_m@-1mm"), "ee50_radius@-1mm");
  EXPECT_EQ(name_without_unit("scatter_rms_rad"), "scatter_rms");
  EXPECT_EQ(name_without_unit("ee_within_10um"), "ee_within_10um");
}

TEST(StatisticName, OfScalarStatisticsIsFixed) {
  EXPECT_EQ(statistic_name(ScatterRms{}), "scatter_rms_rad");
  EXPECT_EQ(statistic_name(ScatterMean{}), "scatter_mean_rad");
  EXPECT_EQ(statistic_name(StrehlRatio{}), "strehl");
  EXPECT_EQ(statistic_name(EnsquaredThrough{12.5e-6, 1e-3}), "ensquared_within_12.5um@1mm");
  EXPECT_EQ(statistic_name(ModulationTransfer{2.5e4}), "mtf@25/mm");
  EXPECT_EQ(statistic_name(SpotFwhm{1e-6}), "spot_fwhm_m");
  EXPECT_EQ(statistic_name(RmsHeight{}), "rms_height_m");
}
