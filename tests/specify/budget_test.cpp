// Tests the written forms of budgets: units, diameters, plate scale.
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

// A circle at f/500, so slow that the rim scatters like the middle, with fine roughness. The closed forms are
// a core of exp(-g^2), which is a sharp peak of the transfer function at 0, and the aperture's transfer
// function (2/pi)(acos x - x sqrt(1 - x^2)).
TEST(Budget, OfLightHasItsClosedForms) {
  const double lambda = 500e-9, f = 100, radius = 0.1, rms = 20e-9;
  const double core = std::exp(-std::pow(4 * std::numbers::pi * rms / lambda, 2));
  const RadialPsd psd(UniformPsd{rms, 5000, 10000});
  const GhsPupil pupil({f, -1, {}}, CircleAperture{2 * radius}, lambda);
  const GeneralisedHarveyShack mean(psd, pupil);
  const auto value = [&](const LightProperty& what) { return LightProperties({what}, pupil)(mean)[0]; };
  EXPECT_NEAR(value(TotalScatter{}), 1 - core, 1e-6);
  EXPECT_NEAR(value(StrehlRatio{}), core, 3e-6);  // 1e-6 of the scattered energy is there
  const double cutoff = 2 * radius / (lambda * f), x = 0.3;
  const double aperture = 2 / std::numbers::pi * (std::acos(x) - x * std::sqrt(1 - x * x));
  EXPECT_NEAR(value(ModulationTransfer{x * cutoff}), aperture * core, 1e-5);
  EXPECT_NEAR(value(ModulationTransfer{0}), 1, 1e-9);
}

TEST(Budget, OfWidthsOfLight) {
  const Budget side = parse_budget("ensquared80_side@0.5mm", "<= 0.4 arcsec");
  EXPECT_EQ(std::get<EnsquaredSide>(*side.of_light).fraction, 0.8);
  EXPECT_EQ(std::get<EnsquaredSide>(*side.of_light).dz, 0.5e-3);
  EXPECT_DOUBLE_EQ(side.limit, 0.4 * kArcsec);
  EXPECT_DOUBLE_EQ(budgeted(side, 6e-6, 2), 3e-6) << "a full side over f on the sky";
  EXPECT_EQ(budget_name(side), "ensquared80_side_rad@0.5mm");
  const Budget width = parse_budget("fwhm", "<= 10 um");
  EXPECT_EQ(std::get<IrradianceFwhm>(*width.of_light).dz, 0);
  EXPECT_EQ(budgeted(width, 6e-6, 2), 6e-6);
  EXPECT_EQ(budget_name(width), "fwhm_m");
}

TEST(Budget, OfAirAndOfScatter) {
  const Budget pssn = parse_budget("pssn@20cm", ">= 95 %");
  EXPECT_DOUBLE_EQ(std::get<PointSourceSensitivity>(*pssn.of_light).r0, 0.2);
  EXPECT_FALSE(is_less_of_smoother(pssn));
  EXPECT_EQ(budget_name(pssn), "pssn@20cm");
  EXPECT_EQ(std::get<PointSourceSensitivity>(*parse_budget("pssn", ">= 0.9").of_light).r0, 0.15);
  for (const char* bound : {"<= 2e-3", "<= 2e-3 /sr", "<= 2e-3 1/sr", "<= 2e-3 sr^-1", "<= 2e-3/sr"}) {
    const Budget bsdf = parse_budget("bsdf@5deg", bound);
    EXPECT_DOUBLE_EQ(std::get<PatchBsdf>(*bsdf.of_light).theta, std::numbers::pi / 36);
    EXPECT_EQ(bsdf.limit, 2e-3) << bound;
    EXPECT_EQ(budget_name(bsdf), "bsdf_per_sr@5deg");
  }
  EXPECT_EQ(parse_budget("bsdf@1mrad", "<= 40 /sr").limit, 40) << "no share";
  EXPECT_EQ(in_budget_unit(parse_budget("bsdf@5deg", "<= 2e-3 /sr"), 1e-3), "0.001 /sr");
}

TEST(Budget, OfTheSurface) {
  const Budget height = parse_budget("rms_height@10/m-0.1/mm", "<= 5 nm RMS");
  EXPECT_EQ(std::get<HeightInBand>(*height.of_surface).f_min, 10);
  EXPECT_EQ(std::get<HeightInBand>(*height.of_surface).f_max, 100);
  EXPECT_EQ(height.limit, 5e-9);
  EXPECT_EQ(height.unit, "nm");
  EXPECT_EQ(budget_name(height), "rms_height_m@10/m-0.1/mm");
  const Budget slope = parse_budget("rms_slope", "<= 2e-6");
  EXPECT_EQ(std::get<SlopeInBand>(*slope.of_surface).f_min, 0);
  EXPECT_EQ(slope.limit, 2e-6);
  EXPECT_EQ(budget_name(slope), "rms_slope");
  EXPECT_EQ(parse_budget("rms_slope@1/m-9/m", "<= 2 urad").limit, 2e-6);
  const Budget root = parse_budget("structure@10mm", "<= 5 nm"),
               square = parse_budget("structure@10mm", "<= 25 nm^2");
  EXPECT_EQ(std::get<HeightDifference>(*root.of_surface).separation, 10e-3);
  EXPECT_EQ(budgeted(root, 4e-9, 2), 4e-9);
  EXPECT_EQ(budget_name(root), "structure_m@10mm");
  EXPECT_DOUBLE_EQ(square.limit, 25e-18);
  EXPECT_DOUBLE_EQ(budgeted(square, 4e-9, 2), 16e-18);
  EXPECT_EQ(in_budget_unit(square, 16e-18), "16 nm^2");
  EXPECT_EQ(budget_name(square), "structure_m2@10mm");
}

TEST(Budget, HeightsInWavelengths) {
  for (const char* bound :
       {"<= lambda/20", "<= 0.05 lambda", "<= 0.05 waves RMS", "<= λ/20 rms", "<= lambda / 20"}) {
    const Budget typed = parse_budget("rms_height", bound);
    EXPECT_TRUE(typed.in_wavelengths) << bound;
    const Budget budget = at_wavelength(typed, 600e-9);
    EXPECT_DOUBLE_EQ(budget.limit, 30e-9) << bound;
    EXPECT_FALSE(budget.in_wavelengths);
    EXPECT_EQ(in_budget_unit(budget, 20e-9), "lambda/30");
    EXPECT_EQ(budget_name(budget), "rms_height_m");
  }
  EXPECT_EQ(at_wavelength(parse_budget("rms_height", "<= 5 nm"), 600e-9).limit, 5e-9);
}

TEST(Budget, EveryKindOfKeyIsRead) {
  for (const BudgetKey& kind : budget_keys()) {
    const bool read = [&] {
      for (const char* bound : {"<= 5 nm", "<= 0.5", "<= 5 urad"}) try {
          return !parse_budget(kind.sample, bound).key.empty();
        } catch (const UnitError&) {
        }
      return false;
    }();
    EXPECT_TRUE(read) << kind.sample;
  }
}

TEST(Budget, SaysWhatIsWrong) {
  const struct {
    const char *key, *bound, *said;
  } cases[] = {{"ee80", "<= 1 um", "is not a budget"},
               {"ee100_radius", "<= 1 um", "is not a budget"},
               {"ee80_width", "<= 1 um", "is not a budget"},
               {"rms_height@1mm", "<= 1 um", "is not a budget"},
               {"ee80_radius", "1 um", "<= or >="},
               {"ee80_radius", "< 1 um", "<= or >="},
               {"ee80_radius", "<= 1", "no unit"},
               {"ee80_radius", "<= 1 kg", "arcsec"},
               {"ee80_radius", "<= 0 um", "not above zero"},
               {"rms_height", "<= 1 arcsec", "nm"},
               {"scatter_rms", "<= 1 um", "arcsec"},
               {"strehl", ">= 1.2", "not below 1"},
               {"strehl", ">= 80 nm", "%"},
               {"mtf@20", ">= 0.5", "is not a budget"},
               {"mtf", ">= 0.5", "is not a budget"},
               {"tis", "<= 0", "not above zero"},
               {"ensquared80", "<= 1 um", "ensquared80_side"},
               {"pssn", ">= 1", "not below 1"},
               {"pssn@0m", ">= 0.9", "needs a value above zero"},
               {"bsdf", "<= 1", "bsdf@5deg"},
               {"bsdf@90deg", "<= 1", "not below 90 deg"},
               {"bsdf@5deg", "<= 1 nm", "per steradian"},
               {"rms_height@10/m", "<= 1 nm", "is not a budget"},
               {"rms_height@10/m-10/m", "<= 1 nm", "must exceed the lower"},
               {"rms_height", "<= lambda/0", "not finite"},
               {"rms_height", "<= 5 kg", "lambda/20"},
               {"ee80_radius", "<= lambda/20", "arcsec"},
               {"ee80_radius", "<= 5 um RMS", "arcsec"},
               {"rms_slope", "<= 5 nm", "plain number"},
               {"structure", "<= 5 nm", "structure@10mm"},
               {"structure@10mm", "<= 5 nm^3", "nm"}};
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
