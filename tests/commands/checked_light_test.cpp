// The mean PSF in results: against closed forms of the Airy pattern and of a mirror with fine roughness,
// against the budgets of the same names, and the same in a check and in a fit.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "aberfit/commands/run.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/result.h"
#include "aberfit/specify/budget.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;
using std::numbers::pi;

constexpr double kAiry = 250e-6, kFocal = 100;  // lambda N [m]

Study slow_mirror(const std::string& psd, const std::string& theory) {
  return parse_study(R"({"aberfit": 1, "mirror": {"focal_length": "100 m"}, "light": {"wavelength": "500 nm"},
    "aperture": {"shape": "circle", "diameter": "0.2 m"}, "target": {"theory": ")" +
                         theory + R"("}, "roughness": {"psd": )" + psd + "}}",
                     "study.json");
}

ordered_json light_of(const Study& study) {
  return to_json(run_check(study, {}), ordered_json::object())["scene"]["mean_light"];
}

TEST(CheckedLight, OfFineRoughnessIsTheAiryPatternOfItsCore) {
  // The roughness has at least 400 cycles across the aperture, so it scatters to hundreds of Airy radii.
  const double rms = 2e-9, core = std::exp(-std::pow(4 * pi * rms / 500e-9, 2));
  const ordered_json light = light_of(
      slow_mirror(R"({"model": "uniform", "rms": "2 nm", "f_min": "2000 /m", "f_max": "4000 /m"})", "ghs"));
  EXPECT_EQ(light["theory"], "ghs");
  // Scattering takes 0.25 % from the energy in the core. Radii where the Airy curve is flat change by more.
  EXPECT_NEAR(double(light["fwhm_m"]) / (1.028994 * kAiry), 1, 1e-6);
  EXPECT_NEAR(double(light["ee50_diameter_m"]) / (2 * 0.5352 * kAiry), 1, 5e-3);
  EXPECT_EQ(light["hew_m"], light["ee50_diameter_m"]);
  EXPECT_NEAR(double(light["strehl"]), core, 1e-6);
  EXPECT_NEAR(double(light["tis"]), 1 - core, 1e-6);
  EXPECT_NEAR(double(light["pssn@0.15m"]), core * core, 1e-6) << "the core alone is seen through the air";
  for (const char* key :
       {"ee50_diameter", "ee80_diameter", "ee90_diameter", "hew", "fwhm", "ensquared80_side"})
    EXPECT_DOUBLE_EQ(double(light[std::string(key) + "_rad"]),
                     double(light[std::string(key) + "_m"]) / kFocal)
        << key;
  // This square contains the inscribed disc and lies inside the circumscribed one.
  const double side = light["ensquared80_side_m"], diameter = light["ee80_diameter_m"];
  EXPECT_LT(side, diameter);
  EXPECT_GT(side, diameter / std::numbers::sqrt2);
}

TEST(CheckedLight, IsWhatBudgetsOfTheSameNamesLimit) {
  const Study study = slow_mirror(
      R"({"model": "k-correlation", "rms": "40 nm", "B": "0.1 m", "exponent": 3, "f_min": "5 /m", "f_max": "100 /m"})",
      "ghs");
  const ordered_json light = light_of(study);
  const GhsPupil pupil(study.mirror, study.aperture, study.wavelength);
  const GeneralisedHarveyShack mean(RadialPsd(*study.psd), pupil);
  int compared = 0;
  for (const auto& item : light.items()) {
    if (item.key() == "theory") continue;
    const std::string name = item.key();
    const std::size_t unit = std::min(name.find("_m"), name.find("_rad"));
    const std::string key = name.substr(0, unit);
    const Budget budget = parse_budget(key, unit == std::string::npos   ? "<= 0.5"
                                            : name.substr(unit) == "_m" ? "<= 1 um"
                                                                        : "<= 1 urad");
    EXPECT_EQ(budget_name(budget), name);
    const double value = budget.of_light ? LightProperties({*budget.of_light}, pupil)(mean)[0]
                                         : mean.predict({budget.statistic})[0];
    EXPECT_DOUBLE_EQ(double(item.value()), budgeted(budget, value, kFocal)) << name;
    ++compared;
  }
  EXPECT_EQ(compared, 15);
}

// The diameter is twice 2 f s sqrt(-2 ln(1 - p)), with the per-axis slope s = pi sigma sqrt(f_min^2 +
// f_max^2).
TEST(CheckedLight, OfRaysHasDiametersAlone) {
  const ordered_json light = light_of(slow_mirror(
      R"({"model": "uniform", "rms": "50 nm", "f_min": "20 /m", "f_max": "60 /m"})", "geometric"));
  EXPECT_EQ(light["theory"], "geometric");
  const double slope = pi * 50e-9 * std::sqrt(4000.0);
  EXPECT_NEAR(double(light["ee80_diameter_m"]) / (4 * kFocal * slope * std::sqrt(-2 * std::log(0.2))), 1,
              1e-6);
  EXPECT_FALSE(light.contains("strehl"));
  EXPECT_FALSE(light.contains("fwhm_m"));
}

TEST(CheckedLight, IsInTheResultOfAFit) {
  const Study study = parse_study(
      R"({"aberfit": 1, "mirror": {"focal_length": "100 m"}, "light": {"wavelength": "500 nm"},
      "aperture": {"shape": "circle", "diameter": "0.2 m"}, "target": {"statistics": {"ee50": {}, "ee80": {}}},
      "terms": {"zernike": {"n_max": 6}},
      "roughness": {"psd": {"model": "uniform", "rms": "40 nm", "f_min": "5 /m", "f_max": "15 /m"}}})",
      "study.json");
  const ordered_json fitted = to_json(run_fit(study, {}), ordered_json::object());
  EXPECT_EQ(fitted["scene"]["mean_light"], light_of(study));
  EXPECT_TRUE(fitted["scene"]["mean_light"].contains("strehl"));
}

}  // namespace
}  // namespace aberfit
