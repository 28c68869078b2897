// Fast values of theory against the targets of a fit of the same study.
#include "aberfit/method/theory_values.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "aberfit/core/errors.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

// Rounding of one formula evaluated in two ways.
constexpr double kRounding = 1e-12;

Study study_of(const std::string& more, double rms_nm = 60) {
  return parse_study(fmt::format(R"({{ "aberfit": 1, "mirror": {{ "focal_length": "2.8 m" }},
    "aperture": {{ "shape": "circle", "diameter": "0.4 m" }}, "light": {{ "wavelength": "632.8 nm" }},
    "roughness": {{ "psd": {{ "model": "uniform", "rms": "{} nm", "f_min": "2.5 /m", "f_max": "19.96 /m" }} }},
    "target": {{ {} }} }})",
                                 rms_nm, more),
                     "theory_values_test");
}

const char* const kAsked =
    R"("statistics": { "ee35": {}, "ee80": { "planes": ["0 m", "1 mm"] }, "ring_fwhm": {}, "spot_fwhm": {},
       "ee50": { "value": "30 um" }, "scatter_mean": {}, "rms_height": {} })";

TEST(TheoryValues, AreTheTargetsOfAFit) {
  for (const char* theory :
       {"", R"("theory": "geometric", )", R"("theory": "ghs", )", R"("convention": "paper", )"}) {
    const Study study = study_of(theory + std::string(kAsked));
    const TheoryValues found = theory_values(study);
    const Groundwork ground = lay_groundwork(study);
    const TargetSets targets = make_targets(study, ground, 1);
    EXPECT_EQ(found.theory, targets.theory);
    ASSERT_EQ(found.statistics.size(), targets.fitted.size()) << theory;
    for (std::size_t k = 0; k < targets.fitted.size(); ++k) {
      const auto& [statistic, value] = found.statistics[k];
      const std::string name = statistic_name(statistic);
      EXPECT_EQ(name, statistic_name(targets.fitted[k].statistic)) << theory;
      EXPECT_NEAR(value / targets.fitted[k].value, 1, kRounding) << name << theory;
    }
    EXPECT_EQ(found.numbers.kappa, ground.numbers.kappa);
    EXPECT_EQ(found.numbers.g, ground.numbers.g);
  }
}

TEST(TheoryValues, ComeFromTheTheoryThatAFitTakes) {
  for (const char* target : {R"("theory": "auto")", R"("theory": "rays")", R"("theory": "geometric")",
                             R"("theory": "ghs")", R"("convention": "paper")"})
    for (const double rms : {5.0, 60.0, 2000.0}) {
      const Study study = study_of(target, rms);
      const RadialPsd psd(*study.psd);
      EXPECT_EQ(theory_of_targets(study, psd), choose_physics(study, requested_physics(study), &psd).theory)
          << target << rms;
    }
  // A mirror without symmetry has no closed form and uses random rays.
  const Study bent = parse_study(
      R"({ "aberfit": 1, "mirror": { "focal_length": "2.8 m", "zernike": { "noll": { "5": "1 um" } } },
    "aperture": { "shape": "circle", "diameter": "0.4 m" }, "light": { "wavelength": "632.8 nm" },
    "roughness": { "psd": { "model": "uniform", "rms": "60 nm", "f_min": "2.5 /m", "f_max": "19.96 /m" } },
    "target": { "convention": "paper" } })",
      "theory_values_test");
  EXPECT_EQ(theory_of_targets(bent, RadialPsd(*bent.psd)), Theory::kRays);
}

TEST(TheoryValues, WithoutAskedStatisticsAreAFewOfTheFocus) {
  const TheoryValues found = theory_values(study_of(""));
  std::vector<std::string> names;
  for (const auto& [statistic, value] : found.statistics) names.push_back(statistic_name(statistic));
  EXPECT_EQ(names, (std::vector<std::string>{"ee50_radius_m", "ee80_radius_m", "ee90_radius_m",
                                             "scatter_rms_rad", "rms_height_m"}));
  EXPECT_NEAR(found.statistics.back().second, 60e-9, 1e-9);
}

TEST(TheoryValues, AreRefusedWhereAFitWouldBe) {
  EXPECT_THROW(theory_values(study_of(R"("theory": "ghs", "statistics": { "rms_radius": {} })")), FieldError);
  const Study given =
      parse_study(R"({ "aberfit": 1, "mirror": { "focal_length": "1 m" }, "aperture": { "shape": "circle",
    "diameter": "0.2 m" }, "light": { "wavelength": "500 nm" }, "target": { "statistics": { "ee50": { "value": "9 um" } } },
    "terms": { "zernike": { "n_max": 4 } }, "fit": { "prior": "zero-mean" } })",
                  "theory_values_test");
  EXPECT_THROW(theory_values(given), FieldError);
}

}  // namespace
}  // namespace aberfit
