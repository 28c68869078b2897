// Which model a study gets, what it is judged on, and what `check` says about both.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/report/check_report.h"
#include "aberfit/report/trace_report.h"
#include "aberfit/study/read_study.h"
#include "aberfit/theory/generalised_harvey_shack.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;

constexpr double kLambda = 632.8e-9, kFocal = 2.8, kDiameter = 0.4;

// Uniform PSDs whose regime is known: g = 4 pi sigma/lambda = 0.5 in waves; 3.97 with a spot of 2.8 and of 12
// Airy ee90.
const char* const kSmooth =
    R"({"model": "uniform", "rms": "25.18 nm", "f_min": "2.5 /m", "f_max": "19.96 /m"})";
const char* const kShallow = R"({"model": "uniform", "rms": "200 nm", "f_min": "1 /m", "f_max": "3 /m"})";
const char* const kRough = R"({"model": "uniform", "rms": "200 nm", "f_min": "2.5 /m", "f_max": "13 /m"})";

std::string text_of(const std::string& psd, const std::string& target, const std::string& trace = "{}",
                    const std::string& aperture = R"({"shape": "circle", "diameter": "0.4 m"})",
                    const std::string& rest = "", const std::string& conic = "-1") {
  return R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m", "conic": )" + conic + R"(},
    "aperture": )" +
         aperture + R"(, "light": {"wavelength": "632.8 nm"}, "roughness": {"psd": )" + psd +
         R"(}, "target": )" + target + R"(, "trace": )" + trace + rest + "}";
}
Study study_of(const std::string& psd, const std::string& target = "{}", const std::string& trace = "{}") {
  return parse_study(text_of(psd, target, trace), "study.json");
}
ordered_json check(const Study& study) { return to_json(run_check(study, {}), resolved_study(study)); }

bool warns(const ordered_json& result, const std::string& code) {
  for (const auto& warning : result["warnings"])
    if (warning["code"] == code) return true;
  return false;
}

// The pointer and the allowed words of the error that `run` ends in.
template <typename Run>
std::string error_of(Run run) {
  try {
    run();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ModelOfAStudy, AutoTakesWhatTheSceneNeeds) {
  struct Case {
    const char *psd, *theory, *model;
  };
  for (const Case& c :
       {Case{kSmooth, "ghs", "waves"}, Case{kShallow, "ghs", "waves"}, Case{kRough, "geometric", "rays"}}) {
    const ordered_json scene = check(study_of(c.psd))["scene"];
    EXPECT_EQ(scene["theory"], c.theory) << scene["reason"];
    EXPECT_EQ(scene["model"], c.model);
    EXPECT_EQ(scene["needed"], c.model);
    EXPECT_EQ(scene["reason"].get<std::string>().back(), '.');
  }
}

TEST(ModelOfAStudy, ANamedTheoryBringsItsModelAndANamedModelWins) {
  const char* const kTheories[] = {"geometric", "rays", "ghs"};
  const char* const kModels[] = {"rays", "rays", "waves"};
  const std::string few = R"(, "statistics": {"ee90": {}}})";
  for (int t = 0; t < 3; ++t) {
    const std::string target = R"({"theory": ")" + std::string(kTheories[t]) + '"' + few;
    EXPECT_EQ(check(study_of(kRough, target))["scene"]["theory"], kTheories[t]);
    EXPECT_EQ(check(study_of(kRough, target))["scene"]["model"], kModels[t]);
    for (const char* model : {"rays", "waves"}) {
      const std::string trace = R"({"model": ")" + std::string(model) + "\"}";
      const ordered_json scene = check(study_of(kRough, target, trace))["scene"];
      EXPECT_EQ(scene["theory"], kTheories[t]);
      EXPECT_EQ(scene["model"], model);
    }
  }
}

TEST(ModelOfAStudy, TheResolvedStudyKeepsTheWordsOfTheStudy) {
  const Study study = study_of(kSmooth, R"({"theory": "ghs"})", R"({"model": "waves"})");
  const ordered_json resolved = resolved_study(study);
  EXPECT_EQ(resolved["target"]["theory"], "ghs");
  EXPECT_EQ(resolved["trace"]["model"], "waves");
  EXPECT_EQ(resolved_study(parse_study(resolved.dump(), "again.json")), resolved);
  EXPECT_EQ(resolved_study(study_of(kSmooth))["target"]["theory"], "auto");
}

TEST(ModelOfAStudy, RaysConvolvedWithThePatternAreRefusedWithWhatToWriteInstead) {
  const std::string theory = error_of([] { study_of(kShallow, R"({"theory": "convolved"})"); });
  const std::string model = error_of([] { study_of(kShallow, "{}", R"({"model": "convolved"})"); });
  EXPECT_NE(theory.find("/target/theory"), std::string::npos) << theory;
  EXPECT_NE(theory.find("\"auto\" or \"ghs\""), std::string::npos) << theory;
  EXPECT_NE(model.find("/trace/model"), std::string::npos) << model;
  EXPECT_NE(model.find("\"auto\" or \"waves\""), std::string::npos) << model;
  for (const std::string& error : {theory, model})
    for (const char* word : {"were removed", "miss ee35 in focus by 13 %", "a third of the time of waves"})
      EXPECT_NE(error.find(word), std::string::npos) << error;
  EXPECT_EQ(study_schema().dump().find("convolved"), std::string::npos);
}

TEST(ModelOfAStudy, ConventionPaperIsARuleForRays) {
  const ordered_json smooth = check(study_of(kSmooth, R"({"convention": "paper"})"));
  EXPECT_EQ(smooth["scene"]["theory"], "geometric");
  EXPECT_EQ(smooth["scene"]["model"], "rays");
  EXPECT_EQ(smooth["scene"]["needed"], "waves");
  EXPECT_TRUE(warns(smooth, "theory-fallback"));
  EXPECT_TRUE(warns(smooth, "rays-not-valid"));
  EXPECT_FALSE(warns(check(study_of(kRough, R"({"convention": "paper"})")), "theory-fallback"));
  const std::string error =
      error_of([] { check(study_of(kRough, R"({"convention": "paper", "theory": "ghs"})")); });
  EXPECT_NE(error.find("/target/theory"), std::string::npos) << error;
  EXPECT_NE(error.find("\"geometric\""), std::string::npos) << error;
}

TEST(ModelOfAStudy, WhereWavesCannotBeComputedAutoSaysSoAndANameIsRefused) {
  const std::string polygon =
      R"({"shape": "polygon", "vertices": [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]})";
  const std::string circle = R"({"shape": "circle", "diameter": "0.4 m"})";
  struct Case {
    std::string aperture, trace, conic;
  };
  for (const Case& c : {Case{polygon, "{}", "-1"}, Case{circle, "{}", "-0.9"},
                        Case{circle, R"({"centre": "centroid"})", "-1"}}) {
    const auto study = [&](const std::string& target) {
      return parse_study(text_of(kSmooth, target, c.trace, c.aperture, "", c.conic), "study.json");
    };
    const ordered_json result = check(study("{}"));
    EXPECT_EQ(result["scene"]["theory"], "geometric");
    EXPECT_EQ(result["scene"]["needed"], "waves");
    EXPECT_TRUE(warns(result, "theory-fallback"));
    EXPECT_TRUE(warns(result, "rays-not-valid"));
    const std::string error = error_of([&] { check(study(R"({"theory": "ghs"})")); });
    EXPECT_NE(error.find("/target/theory"), std::string::npos) << error;
  }
}

TEST(ModelOfAStudy, AnRmsRadiusExistsForRaysOnly) {
  const std::string statistics = R"("statistics": {"rms_radius": {}}})";
  const std::string error = error_of([&] { check(study_of(kSmooth, R"({"theory": "ghs", )" + statistics)); });
  EXPECT_NE(error.find("/target/statistics/rms_radius"), std::string::npos) << error;
  EXPECT_NE(error.find("infinite"), std::string::npos) << error;
  EXPECT_NO_THROW(check(study_of(kRough, "{" + statistics)));
}

TEST(ModelOfAStudy, EveryTheoryHasTheOtherStatistics) {
  const std::string statistics =
      R"("statistics": {"spot_fwhm": {"bandwidth": "2 um"}, "ring_fwhm": {}, "rms_height": {}, "scatter_rms": {}}})";
  RunOptions options;
  for (const char* theory : {"geometric", "rays", "ghs"}) {
    const Study study = study_of(kRough, R"({"theory": ")" + std::string(theory) + "\", " + statistics,
                                 R"({"model": "rays"})");
    const ordered_json target = to_json(run_trace(study, options), resolved_study(study))["target"];
    ASSERT_EQ(target.size(), 4u);
    for (const auto& item : target.items()) EXPECT_GT(item.value().get<double>(), 0) << item.key();
    EXPECT_NEAR(target["rms_height_m"].get<double>(), 200e-9, 1e-15);
    // Geometric slopes under every theory: sqrt2 2 s, s = pi sigma sqrt(f_max^2 + f_min^2), less the 0.13 %
    // that the aperture at f/7 takes; perturbed rays add sampling errors.
    const double paraxial = std::numbers::sqrt2 * 2 * std::numbers::pi * 200e-9 * std::hypot(2.5, 13.0);
    EXPECT_NEAR(target["scatter_rms_rad"].get<double>() / paraxial, 1, 3e-3) << theory;
  }
}

TEST(Check, TellsTheHarveyShackSpotAndTheErrorsOfSimplerModels) {
  const ordered_json scene = check(study_of(kSmooth))["scene"];
  const GeneralisedHarveyShack ghs(RadialPsd(UniformPsd{25.18e-9, 2.5, 19.96}), Mirror{kFocal, -1, {}},
                                   CircleAperture{kDiameter}, kLambda);
  const double ee90 = ghs.encircled_energy_radius(0.9, 0);
  EXPECT_NEAR(scene["ghs"]["ee90_radius_m"].get<double>() / ee90, 1, 1e-9);
  EXPECT_NEAR(scene["ghs"]["ee80_radius_m"].get<double>() / ghs.encircled_energy_radius(0.8, 0), 1, 1e-9);
  EXPECT_NEAR(scene["ghs"]["ee50_radius_m"].get<double>() / ghs.encircled_energy_radius(0.5, 0), 1, 1e-9);
  const double g = 4 * std::numbers::pi * 25.18e-9 / kLambda;
  EXPECT_NEAR(scene["ghs"]["tis"].get<double>(), 1 - std::exp(-g * g), 1e-12);
  EXPECT_NEAR(scene["ghs"]["core_share"].get<double>(), std::exp(-g * g), 1e-12);
  const double slope = std::numbers::pi * 25.18e-9 * std::hypot(2.5, 19.96);
  const double rays = std::sqrt(2 * std::numbers::ln10) * 2 * kFocal * slope;
  EXPECT_NEAR(scene["rays_ee90_radius_m"].get<double>() / rays, 1, 1e-9);
  EXPECT_NEAR(scene["model_error"]["ray_ee90"].get<double>(), rays / ee90 - 1, 1e-9);
  EXPECT_EQ(scene["model_error"].size(), 2u);
  EXPECT_NEAR(scene["paper_ratio_r"].get<double>(), 1.84, 0.01);  // a quarter of the R of 100 nm
  EXPECT_EQ(scene["paper_verdict"], "unclear");
}

TEST(Check, PrintsThePapersTableWithBothVerdicts) {
  RunOptions options;
  options.paper_table.emplace();
  const Study study = study_of(kRough);
  const CheckReport report = run_check(study, options);
  const std::string table = summary_table(report);
  const ordered_json result = to_json(report, resolved_study(study));
  const ordered_json& rows = result["paper_table"]["rows"];
  ASSERT_EQ(rows.size(), 36u);
  int printed = 0;
  for (const auto& row : rows) {
    const double sigma = row["rms_height_m"], l = row["correlation_length_m"], d = row["diameter_m"];
    const double ratio = row["paper_ratio_r"];
    EXPECT_NEAR(ratio / (2 * sigma * d / (1.22 * 500e-9 * l)), 1, 1e-9);
    EXPECT_NEAR(row["g"].get<double>() / (4 * std::numbers::pi * sigma / 500e-9), 1, 1e-9);
    // Golden arithmetic: R = 655.738, 1639.34, 3278.69 of 1 nm and 1 um; the others in paper_table_test.
    const auto is = [](double a, double b) { return std::abs(a / b - 1) < 1e-9; };
    const double golden[][4] = {
        {1e-9, 1e-6, 0.2, 655.737704918}, {1e-9, 1e-6, 0.5, 1639.3442623}, {1e-9, 1e-6, 1.0, 3278.68852459}};
    for (const auto& cell : golden) {
      if (!is(sigma, cell[0]) || !is(l, cell[1]) || !is(d, cell[2])) continue;
      ++printed;
      EXPECT_NEAR(ratio / cell[3], 1, 1e-9);
      EXPECT_EQ(row["paper_verdict"], "rays");
      // 1 nm scatters 0.06 % of the light: nothing that rays could say about the spot.
      if (sigma < 2e-9) {
        EXPECT_EQ(row["needed"], "waves");
      }
    }
  }
  EXPECT_EQ(printed, 3);
  EXPECT_NE(table.find("655.7"), std::string::npos);
  EXPECT_NE(table.find("scattered beyond 10 degrees in these"), std::string::npos) << table;
}

// A few statistics at the focus, few terms.
const char* const kFew = R"("statistics": {"ee50": {}, "ee80": {}, "ee90": {}}})";
const std::string kLenient = R"(, "terms": {"zernike": {"n_max": 14}}, "equivalence": {"margin": "2 %"})";

TEST(Judgement, RaysForcedOnASmoothSurfaceAreDifferentAndSayWhy) {
  const std::string target = R"({"theory": "geometric", )" + std::string(kFew);
  const Study study = parse_study(
      text_of(kSmooth, target, R"({"rays": 16384})", R"({"shape": "circle", "diameter": "0.4 m"})", kLenient),
      "study.json");
  const ResultDocument result = run_fit(study, {});
  ASSERT_TRUE(result.needed_judgement.has_value());
  EXPECT_EQ(result.model, "rays");
  EXPECT_EQ(result.needed, "waves");
  EXPECT_EQ(result.verdict, Verdict::kDifferent);
  const NeededJudgement& needed = *result.needed_judgement;
  EXPECT_EQ(needed.theory, "ghs");
  EXPECT_EQ(needed.model, "waves");
  EXPECT_EQ(needed.reason.find("rays are not valid here: kappa = "), 0u) << needed.reason;
  EXPECT_NE(needed.reason.find("off the Harvey-Shack prediction"), std::string::npos) << needed.reason;
  // The targets of this judgement are Harvey-Shack's, not the fit's.
  const GeneralisedHarveyShack ghs(RadialPsd(UniformPsd{25.18e-9, 2.5, 19.96}), Mirror{kFocal, -1, {}},
                                   CircleAperture{kDiameter}, kLambda);
  ASSERT_EQ(needed.metrics.size(), 3u);
  EXPECT_NEAR(needed.metrics[2].target / ghs.encircled_energy_radius(0.9, 0), 1, 1e-9);
  EXPECT_GT(std::abs(result.targets[2].value / needed.metrics[2].target - 1), 0.05);
  const ordered_json json = to_json(result, {})["equivalence"];
  EXPECT_EQ(json["verdict"], "different");
  EXPECT_EQ(json["needed"]["reason"], needed.reason);
  EXPECT_EQ(json["needed"]["metrics"].size(), 3u);
  EXPECT_NE(summary_table(result, false).find("Judged on waves: rays are not valid here"), std::string::npos);
}

TEST(Judgement, RaysWhereRaysAreNeededAreJudgedOnce) {
  const std::string target = R"({"theory": "geometric", )" + std::string(kFew);
  const Study study = parse_study(
      text_of(kRough, target, R"({"rays": 16384})", R"({"shape": "circle", "diameter": "0.4 m"})", kLenient),
      "study.json");
  const ResultDocument result = run_fit(study, {});
  EXPECT_FALSE(result.needed_judgement.has_value());
  EXPECT_EQ(result.needed, "rays");
  EXPECT_FALSE(to_json(result, {})["equivalence"].contains("needed"));
}

TEST(Judgement, WavesFitASmoothSurfaceToItsHarveyShackSpot) {
  const Study study = parse_study(
      text_of(kSmooth, "{" + std::string(kFew), "{}", R"({"shape": "circle", "diameter": "0.4 m"})",
              R"(, "terms": {"zernike": {"n_max": 27}}, "equivalence": {"margin": "2 %"})"),
      "study.json");
  const ResultDocument result = run_fit(study, {});
  EXPECT_EQ(result.theory, "ghs");
  EXPECT_EQ(result.model, "waves");
  EXPECT_EQ(result.fit.status, FitStatus::kConverged) << result.fit.message;
  EXPECT_FALSE(result.needed_judgement.has_value());
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(result.validated[Eigen::Index(k)] / result.targets[k].value, 1, 2e-3)
        << result.metrics[k].name;
  for (const EquivalenceMetric& metric : result.metrics) {
    if (metric.held_out) continue;
    EXPECT_EQ(metric.verdict, Verdict::kEquivalent) << metric.name;
  }
}

TEST(Realisation, NearTheMarginDrawsAreMeasuredAndCompared) {
  // N_eff = 50: 9 % by the law of rays, within a factor 2 of a margin of 10 %.
  const std::string target = R"({"theory": "geometric", "statistics": {"ee90": {}}})";
  const auto result_of = [&](const char* margin) {
    return run_fit(parse_study(text_of(kRough, target, R"({"rays": 8192})",
                                       R"({"shape": "circle", "diameter": "0.4 m"})",
                                       R"(, "equivalence": {"margin": ")" + std::string(margin) + "\"}"),
                               "study.json"),
                   {});
  };
  const ResultDocument near = result_of("10 %");
  ASSERT_TRUE(near.realisation.has_value());
  EXPECT_EQ(near.realisation->draws, 32);
  EXPECT_NEAR(near.realisation->predicted, 0.65 / std::sqrt(near.scene.n_eff), 1e-12);
  // 32 draws know a spread to 13 %; the law itself to a third: half to double is four standard errors away.
  EXPECT_GT(near.realisation->measured, 0.5 * near.realisation->predicted);
  EXPECT_LT(near.realisation->measured, 2.0 * near.realisation->predicted);
  const ordered_json json = to_json(near, {})["scene"]["realisation"];
  EXPECT_EQ(json["measured"], near.realisation->measured);
  const ResultDocument far = result_of("1 %");
  EXPECT_EQ(far.realisation->draws, 0);
  EXPECT_TRUE(to_json(far, {})["scene"]["realisation"]["measured"].is_null());
}

}  // namespace
}  // namespace aberfit
