#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/report/documents.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

std::string text_of(const std::string& statistics, const std::string& more = "", const char* rms = "100 nm") {
  return std::string(
             R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "aperture": {"shape": "circle", )"
             R"("diameter": "0.4 m"}, "light": {"wavelength": "632.8 nm"}, "output": {"pictures": "none"}, )"
             R"("roughness": {"psd": {"model": "uniform", "rms": ")") +
         rms + R"(", "f_min": "2.5 /m", "f_max": "8 /m"}}, "terms": {"zernike": {"n_max": 14}}, )" +
         R"("equivalence": {"margin": "3 %"}, "target": {)" + more + R"("statistics": )" + statistics + "}}";
}
Study study_of(const std::string& statistics, const std::string& more = "", const char* rms = "100 nm") {
  return parse_study(text_of(statistics, more, rms), "study.json");
}
TargetSets targets_of(const Study& study) { return make_targets(study, lay_groundwork(study), 2); }

std::string refusal(const std::string& statistics) {
  try {
    study_of(statistics);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

const char* const kTwo = R"({"ee_within": {"radii": ["8 um", "20 um"], "planes": ["0 mm", "-0.4 mm"]}})";

TEST(EeWithin, TargetsAreTheTheorysSharesWithAnAbsoluteTolerance) {
  const Study study = study_of(kTwo);
  const Groundwork ground = lay_groundwork(study);
  ASSERT_TRUE(ground.mean_spot);
  const std::vector<Target> fitted = targets_of(study).fitted;
  ASSERT_EQ(fitted.size(), 4u);
  std::size_t k = 0;
  for (const double dz : {0.0, -0.4e-3})
    for (const double radius : {8e-6, 20e-6}) {
      const Target& target = fitted[k++];
      EXPECT_NEAR(target.value, ground.mean_spot->encircled_energy(radius, dz), 1e-9);
      EXPECT_DOUBLE_EQ(target.tolerance, 1e-3);  // absolute, for every fraction
      EXPECT_DOUBLE_EQ(aim_of(target).scale, kFlattestCurve);
    }
  EXPECT_EQ(statistic_name(fitted[0].statistic), "ee_within_8um");
  EXPECT_EQ(statistic_name(fitted[3].statistic), "ee_within_20um@-0.4mm");
  // Geometric rays have a closed form.
  const Study rays = study_of(kTwo, R"("theory": "geometric", )");
  const Groundwork geometric = lay_groundwork(rays);
  EXPECT_NEAR(targets_of(rays).fitted[1].value, geometric.theory->encircled_energy(20e-6, 0), 1e-12);
}

TEST(EeWithin, IsMetByRaysAndByWaves) {
  for (const char* theory : {R"("theory": "geometric", )", ""}) {
    const Study study = study_of(R"({"ee_within": {"radii": ["10 um", "25 um", "50 um"]}, "ee80": {}})",
                                 theory, *theory ? "200 nm" : "40 nm");
    const ResultDocument result = run_fit(study, {});
    EXPECT_EQ(result.scene.model, *theory ? "rays" : "waves");
    EXPECT_EQ(result.fitted.fit.status, FitStatus::kConverged);
    const std::string json = to_json(result, resolved(study, result)).dump();
    EXPECT_NE(json.find("\"ee_within_25um\""), std::string::npos) << json;
    for (std::size_t k = 0; k < 3; ++k) {
      const EquivalenceMetric& metric = result.judgement.metrics[k];
      EXPECT_EQ(metric.verdict, Verdict::kEquivalent) << metric.name << theory;
      const double share = result.fitted.validated[Eigen::Index(k)] - result.fitted.targets[k].value;
      EXPECT_LT(std::abs(share), 0.03 * kFlattestCurve);
      EXPECT_NEAR(metric.share_difference, share, 1e-12);
      EXPECT_NEAR(metric.difference, share / kFlattestCurve, 1e-12);
    }
    EXPECT_NE(text_of(page_of(result, true)).find("ee_within_25um"), std::string::npos);
  }
}

TEST(EeWithin, TakesAValue) {
  const Study study =
      study_of(R"({"ee_within": {"radii": ["30 um"], "value": "70 %", "tolerance": "0.2 %"}})");
  const std::vector<Target> fitted = targets_of(study).fitted;
  ASSERT_EQ(fitted.size(), 1u);
  EXPECT_EQ(fitted[0].value, 0.7);
  EXPECT_DOUBLE_EQ(fitted[0].tolerance, 2e-3);
  EXPECT_EQ(targets_of(study).theory, "given");
}

TEST(EeWithin, RefusesWhatSaysNothing) {
  EXPECT_NE(refusal(R"({"ee_within": {}})").find("radii"), std::string::npos);
  EXPECT_NE(refusal(R"({"ee_within": {"radii": []}})").find("radii"), std::string::npos);
  EXPECT_NE(refusal(R"({"ee_within": {"radii": ["-1 um"]}})").find("radii"), std::string::npos);
  EXPECT_NE(refusal(R"({"ee_within": {"radii": ["1 um", "2 um"], "value": 0.5}})").find("one radius"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"ee_within": {"radii": ["10 um"], "value": 1.2}})").find("value"), std::string::npos);
}

}  // namespace
}  // namespace aberfit
