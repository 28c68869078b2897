// The parts of a verdict: the theory of the study, wave optics, fresh rays, random mirrors of the roughness.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "aberfit/commands/run.h"
#include "aberfit/report/documents.h"
#include "aberfit/study/read_study.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "model_studies.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;

// A few statistics at the focus, few terms.
const char* const kFew = R"("statistics": {"ee50": {}, "ee80": {}, "ee90": {}}})";
const std::string kLenient = R"(, "terms": {"zernike": {"n_max": 14}}, "equivalence": {"margin": "2 %"})";

Study lenient_study(const char* psd, const std::string& target, const std::string& rest = kLenient) {
  return parse_study(
      text_of(psd, target, R"({"rays": 16384})", R"({"shape": "circle", "diameter": "0.4 m"})", rest),
      "study.json");
}

TEST(Judgement, ANamedTheoryDecidesAndLightsAnswerStandsBeside) {
  const Study study =
      parse_study(text_of(kSmooth, R"({"theory": "geometric"})", R"({"pupil": "polar", "rays": 65536})",
                          R"({"shape": "circle", "diameter": "0.4 m"})",
                          R"(, "terms": {"zernike": {"n_max": 28}}, "equivalence": {"margin": "1 %"})"),
                  "study.json");
  const ResultDocument result = run_fit(study, {});
  EXPECT_EQ(result.scene.model, "rays");
  EXPECT_EQ(result.scene.needed, "waves");
  EXPECT_EQ(result.judgement.verdict, Verdict::kEquivalent);
  EXPECT_EQ(result.judgement.verdict, overall(result.judgement.metrics));
  ASSERT_TRUE(result.judgement.light.has_value());
  EXPECT_FALSE(result.judgement.light->decides);
  EXPECT_EQ(result.judgement.light->verdict, Verdict::kDifferent);
  // The wave-optics targets are Harvey-Shack's, not those of the fit.
  const GeneralisedHarveyShack ghs(RadialPsd(UniformPsd{25.18e-9, 2.5, 19.96}), Mirror{kFocal, -1, {}},
                                   CircleAperture{kDiameter}, kLambda);
  ASSERT_EQ(result.judgement.light->metrics.size(), result.fitted.targets.size());
  const auto at = std::find_if(result.judgement.light->metrics.begin(), result.judgement.light->metrics.end(),
                               [](const EquivalenceMetric& m) { return m.name == "ee90_radius_m"; });
  ASSERT_NE(at, result.judgement.light->metrics.end());
  const EquivalenceMetric& ee90 = *at;
  const auto k = std::size_t(at - result.judgement.light->metrics.begin());
  EXPECT_NEAR(ee90.target / ghs.encircled_energy_radius(0.9, 0), 1, 1e-9);
  EXPECT_GT(std::abs(result.fitted.targets[k].value / ee90.target - 1), 0.05);
  EXPECT_NEAR(ee90.difference * ee90.tolerance_share, -ee90.share_difference * ee90.margin, 1e-15);
  const ordered_json json = to_json(result, {})["equivalence"];
  EXPECT_EQ(json["verdict"], "equivalent");
  EXPECT_EQ(json["light"]["decides"], false);
  EXPECT_EQ(json["light"]["verdict"], "different");
  EXPECT_EQ(json["light"]["metrics"].size(), result.fitted.targets.size());
  EXPECT_EQ(json["light"]["metrics"][k]["tolerance_share"], ee90.tolerance_share);
  const std::string headline = page_of(result, false).headline;
  EXPECT_EQ(headline.find("EQUIVALENT by geometric rays: all "), 0u) << headline;
  EXPECT_NE(headline.find("; by wave optics DIFFERENT (ee"), std::string::npos) << headline;
}

TEST(Judgement, RaysThatMeetLightAreJudgedInLight) {
  const ResultDocument result =
      run_fit(lenient_study(kRough, "{" + std::string(kFew),
                            R"(, "terms": {"zernike": {"n_max": 16}}, "equivalence": {"margin": "20 %"})"),
              {});
  EXPECT_EQ(result.scene.theory, "ghs");
  EXPECT_EQ(result.scene.model, "rays");
  EXPECT_EQ(result.scene.needed, "rays");
  ASSERT_TRUE(result.judgement.light.has_value());
  EXPECT_TRUE(result.judgement.light->decides);
  EXPECT_FALSE(result.judgement.light->metrics.empty());
  EXPECT_EQ(result.judgement.verdict, result.judgement.light->verdict);
  EXPECT_EQ(result.judgement.verdict, Verdict::kEquivalent);
  EXPECT_EQ(to_json(result, {})["equivalence"]["light"]["decides"], true);
  EXPECT_EQ(text_of(page_of(result, false)).find("EQUIVALENT by wave optics: all "), 0u);
}

// At 3,600 grid cells across, rays decide, and every interval includes their difference to wave optics.
TEST(Judgement, WhereNoGridHoldsThePhaseRaysDecideWithTheirModelError) {
  const ResultDocument result = run_fit(lenient_study(kSteep, "{" + std::string(kFew)), {});
  EXPECT_EQ(result.scene.model, "rays");
  ASSERT_TRUE(result.judgement.light.has_value());
  EXPECT_TRUE(result.judgement.light->no_grid);
  EXPECT_TRUE(result.judgement.light->metrics.empty());
  EXPECT_NE(result.judgement.light->obstacle.find("grid points across"), std::string::npos)
      << result.judgement.light->obstacle;
  EXPECT_EQ(result.judgement.verdict, overall(result.judgement.metrics));
  for (const EquivalenceMetric& metric : result.judgement.metrics) {
    EXPECT_GT(metric.model_error, 0);
    EXPECT_LT(metric.model_error, 0.02 / 3);
    EXPECT_GE(metric.interval[1] - metric.interval[0], 2 * metric.model_error);
  }
  const ordered_json light = to_json(result, {})["equivalence"]["light"];
  EXPECT_TRUE(light["verdict"].is_null());
  EXPECT_EQ(light["obstacle"], result.judgement.light->obstacle);
  EXPECT_NE(text_of(page_of(result, false)).find(" by rays (no grid can sample the pupil's phase"),
            std::string::npos);
}

// With few rays, the sampling error alone would leave statistics undecided.
TEST(Judgement, NothingIsLeftOpenForWantOfRaysWhereNoGridHoldsThePhase) {
  const ResultDocument result =
      run_fit(parse_study(text_of(kSteep, "{" + std::string(kFew), R"({"rays": 2048})",
                                  R"({"shape": "circle", "diameter": "0.4 m"})", kLenient),
                          "study.json"),
              {});
  ASSERT_TRUE(result.judgement.light && result.judgement.light->no_grid);
  int open = 0;
  std::set<std::string> told;
  for (const EquivalenceMetric& metric : result.judgement.metrics) {
    EXPECT_GT(metric.model_error, 0);
    if (metric.verdict != Verdict::kUndecided) continue;
    ++open;
    // The sampling part is a twentieth of the margin.
    EXPECT_LT(0.5 * (metric.interval[1] - metric.interval[0]) - metric.model_error, 0.05 * 0.02)
        << metric.name;
  }
  EXPECT_LT(open, 10);
  EXPECT_EQ(result.judgement.verdict, overall(result.judgement.metrics));
  for (const Warning& warning : result.warnings)
    EXPECT_TRUE(told.insert(warning.code).second) << "told twice";
}

TEST(Judgement, MoreRaysAreTakenOnlyWhereTheyCouldDecide) {
  const auto judged = [](int rays, bool stop) {
    int times = 0;
    RunOptions how;
    how.progress = [&](const std::string& line) { times += line == "judging on fresh rays"; };
    if (stop) how.interrupted = [&] { return times > 0; };
    run_fit(parse_study(text_of(kSteep, "{" + std::string(kFew), fmt::format(R"({{"rays": {}}})", rays),
                                R"({"shape": "circle", "diameter": "0.4 m"})", kLenient),
                        "study.json"),
            how);
    return times;
  };
  EXPECT_GT(judged(2048, false), 1);
  EXPECT_EQ(judged(2048, true), 1);
  // Fresh rays would grow through 64k, 256k, 1M and 4M; the last steps cannot decide.
  EXPECT_LT(judged(16384, false), 4);
}

// Given values imply no model. Rays come first, and waves where wave optics rejects the result of rays.
TEST(Judgement, GivenValuesAreMetInLight) {
  const std::string target =
      R"({"statistics": {"ee50": {"value": "30 um"}, "ee80": {"value": "50 um"}, "ee90": {"value": "62 um"}}})";
  const ResultDocument result = run_fit(lenient_study(kRough, target), {});
  EXPECT_EQ(result.scene.theory, "given");
  EXPECT_EQ(result.judgement.verdict, Verdict::kEquivalent) << text_of(page_of(result, false));
  EXPECT_EQ(text_of(page_of(result, false)).find("EQUIVALENT by wave optics"), 0u);
}

TEST(Judgement, AMarginThatThePerfectMirrorMeetsSeesNothing) {
  const auto result_of = [](const char* psd) {
    return run_fit(
        lenient_study(psd, "{" + std::string(kFew),
                      R"(, "terms": {"zernike": {"n_max": 12}}, "equivalence": {"margin": "1 %"})"),
        {});
  };
  const auto blind = [](const ResultDocument& result) {
    return std::any_of(result.warnings.begin(), result.warnings.end(),
                       [](const Warning& w) { return w.code == "margin-sees-nothing"; });
  };
  const ResultDocument smooth =
      result_of(R"({"model": "uniform", "rms": "1 nm", "f_min": "2.5 /m", "f_max": "10 /m"})");
  ASSERT_TRUE(smooth.judgement.perfect.has_value());
  EXPECT_LT(smooth.judgement.perfect->mismatch, 1);
  // TIS of 1 nm at 632.8 nm is 3.9e-4, a tenth of the 0.35 % that a margin of 1 % allows at least.
  EXPECT_NEAR(smooth.judgement.perfect->mismatch, 0.1, 0.05);
  EXPECT_TRUE(blind(smooth));
  const ResultDocument rough = result_of(kSmooth);
  EXPECT_GT(rough.judgement.perfect->mismatch, 10);
  EXPECT_FALSE(blind(rough));
}

TEST(Judgement, WavesFitASmoothSurfaceToItsHarveyShackSpot) {
  const Study study = parse_study(
      text_of(kSmooth, "{" + std::string(kFew), "{}", R"({"shape": "circle", "diameter": "0.4 m"})",
              R"(, "terms": {"zernike": {"n_max": 27}}, "equivalence": {"margin": "2 %"})"),
      "study.json");
  const ResultDocument result = run_fit(study, {});
  EXPECT_EQ(result.scene.theory, "ghs");
  EXPECT_EQ(result.scene.model, "waves");
  EXPECT_EQ(result.fitted.fit.status, FitStatus::kConverged) << result.fitted.fit.message;
  EXPECT_FALSE(result.judgement.light.has_value());
  ASSERT_TRUE(result.choices.rays.has_value());
  EXPECT_GT(result.choices.rays->gap, 0);  // the judging grid differs from the fit's
  // The fit's tolerance, and the allowed difference of the judging grid from the fit's: 15 % of the margin.
  constexpr double kApart = 1e-3 + 0.15 * 0.02;
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(result.fitted.validated[Eigen::Index(k)] / result.fitted.targets[k].value, 1, kApart)
        << result.judgement.metrics[k].name;
  for (const EquivalenceMetric& metric : result.judgement.metrics) {
    if (metric.held_out) continue;
    EXPECT_EQ(metric.verdict, Verdict::kEquivalent) << metric.name;
  }
}

// On large grids each comparison takes seconds, so an interrupted run gives only the surface and its verdict.
TEST(Conclusions, OfARunThatWasAskedToStopAreTheVerdictAlone) {
  const auto run = [](bool stop) {
    bool judging = false;
    RunOptions how;
    how.progress = [&](const std::string& line) { judging |= line == "judging on fresh rays"; };
    if (stop) how.interrupted = [&] { return judging; };
    return run_fit(parse_study(text_of(kRough, R"({"theory": "geometric", "statistics": {"ee90": {}}})",
                                       R"({"rays": 8192})", R"({"shape": "circle", "diameter": "0.4 m"})",
                                       R"(, "terms": {"zernike": {"n_max": 20}},
                                          "equivalence": {"margin": "10 %"})"),
                               "study.json"),
                   how);
  };
  const ResultDocument whole = run(false), stopped = run(true);
  EXPECT_FALSE(stopped.judgement.metrics.empty());
  ASSERT_TRUE(whole.judgement.character);
  EXPECT_EQ(whole.judgement.character->zones.size(), 4u);
  EXPECT_FALSE(stopped.judgement.character);
  EXPECT_GT(stopped.fitted.surface.rms_height, 0);
  EXPECT_TRUE(whole.judgement.perfect.has_value());
  EXPECT_FALSE(stopped.judgement.perfect.has_value());
}

// The perfect mirror has a pattern on every grid, but its scatter angles have no derivative, so a finer grid
// does not help. A fit of named terms from a random start shows the cells of the first grid.
TEST(Judgement, AStartWithoutDerivativesIsNotTriedOnFinerGrids) {
  const auto fit = [](const char* start) {
    return run_fit(parse_study(text_of(kSmooth, "{}", "{}", R"({"shape": "circle", "diameter": "0.4 m"})",
                                       fmt::format(R"(, "terms": {{"zernike": {{"n_max": 4}}}},
                                                      "fit": {{"start": "{}"}})",
                                                   start)),
                               "study.json"),
                   {});
  };
  const ResultDocument zero = fit("zero"), draw = fit("draw");
  ASSERT_EQ(zero.scene.model, "waves");
  EXPECT_EQ(zero.fitted.fit.status, FitStatus::kDegenerate);
  EXPECT_NE(zero.fitted.fit.message.find("start from a realisation"), std::string::npos)
      << zero.fitted.fit.message;
  EXPECT_LE(zero.fitted.rays, draw.fitted.rays);
}

// A start of 1 um, which rays accept, has no diffraction pattern. By waves spherical terms start with the
// height of the roughness. A missing value is reported as such, not as an agreement to 0 %.
TEST(SphericalTerms, ByWavesBeginWithTheHeightOfTheRoughness) {
  const auto fit = [](const char* how) {
    return run_fit(
        parse_study(text_of(R"({"model": "k-correlation", "rms": "25 nm", "B": "0.1 m", "exponent": 3,
                                "f_min": "1 /m", "f_max": "20 /m"})",
                            R"({"statistics": {"ee50": {}, "ee80": {}}})", "{}",
                            R"({"shape": "circle", "diameter": "1 m"})",
                            fmt::format(R"(, "terms": {{"spherical": ["c4", "c6", "c8"]}}{})", how)),
                    "study.json"),
        {});
  };
  const ResultDocument automatic = fit("");
  ASSERT_EQ(automatic.scene.model, "waves");
  EXPECT_NE(automatic.fitted.fit.status, FitStatus::kDegenerate) << automatic.fitted.fit.message;
  EXPECT_LT(automatic.fitted.surface.rms_height, 10 * 25e-9);
  EXPECT_LT(automatic.choices.rays->gap, 1);
  const ResultDocument far = fit(R"(, "fit": {"spherical_rms": "20 um"})");
  ASSERT_EQ(far.fitted.fit.status, FitStatus::kDegenerate) << far.fitted.fit.message;
  EXPECT_EQ(far.choices.rays->gap, HUGE_VAL);
  EXPECT_NE(far.choices.rays->reason.find("no value"), std::string::npos) << far.choices.rays->reason;
}

}  // namespace
}  // namespace aberfit
