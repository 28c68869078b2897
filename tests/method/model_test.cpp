// The model that a study gets, and the report of `check` about it.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/report/documents.h"
#include "aberfit/study/read_study.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "model_studies.h"
#include "short_form.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;

ordered_json check(const Study& study) { return to_json(run_check(study, {}), resolved_study(study)); }

bool warns(const ordered_json& result, const std::string& code) {
  for (const auto& warning : result["warnings"])
    if (warning["code"] == code) return true;
  return false;
}

// The pointer and the allowed words of the error that `run` throws.
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
  for (const Case& c : {Case{kSmooth, "ghs", "waves"}, Case{kShallow, "ghs", "waves"},
                        Case{kRough, "ghs", "waves"}, Case{kSteep, "ghs", "rays"}}) {
    const ordered_json scene = check(study_of(c.psd))["scene"];
    EXPECT_EQ(scene["theory"], c.theory) << scene["reason"];
    EXPECT_EQ(scene["model"], c.model);
    EXPECT_EQ(scene["needed"], c.model);
    EXPECT_EQ(scene["reason"].get<std::string>().back(), '.');
  }
}

TEST_WITH_SHORT_FORM(ModelOfAStudy, ANamedTheoryBringsItsModelAndANamedModelWins) {
  const char* const kTheories[] = {"geometric", "rays", "ghs"};
  const char* const kModels[] = {"rays", "rays", "waves"};
  const std::string few = R"(, "statistics": {"ee90": {}}})";
  for (int t = 0; t < 3; ++t) {
    const std::string target = R"({"theory": ")" + std::string(kTheories[t]) + '"' + few;
    EXPECT_EQ(check(study_of(kRough, target))["scene"]["theory"], kTheories[t]);
    EXPECT_EQ(check(study_of(kRough, target))["scene"]["model"], kModels[t]);
    for (const char* model : {"rays", "waves"}) {
      if (!whole && std::string(model) == kModels[t]) continue;  // a named model wins
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

TEST(ModelOfAStudy, ConventionPaperIsARuleForRays) {
  const ordered_json smooth = check(study_of(kSmooth, R"({"convention": "paper"})"));
  EXPECT_EQ(smooth["scene"]["theory"], "geometric");
  EXPECT_EQ(smooth["scene"]["model"], "rays");
  EXPECT_EQ(smooth["scene"]["needed"], "waves");
  EXPECT_TRUE(warns(smooth, "theory-fallback"));
  EXPECT_TRUE(warns(smooth, "rays-not-valid"));
  EXPECT_FALSE(warns(check(study_of(kSteep, R"({"convention": "paper"})")), "theory-fallback"));
  const std::string error =
      error_of([] { check(study_of(kRough, R"({"convention": "paper", "theory": "ghs"})")); });
  EXPECT_NE(error.find("/target/theory"), std::string::npos) << error;
  EXPECT_NE(error.find("\"geometric\""), std::string::npos) << error;
}

TEST(ModelOfAStudy, WhereWavesCannotBeComputedAutoSaysSoAndANameIsRefused) {
  const std::string circle = R"({"shape": "circle", "diameter": "0.4 m"})";
  // 200 nm RMS at 1e5 to 3e5 cycles/m scatter all energy to angles from 4 to 11 degrees and beyond.
  const std::string wide = R"({"model": "uniform", "rms": "200 nm", "f_min": "1e5 /m", "f_max": "3e5 /m"})";
  struct Case {
    std::string psd, trace, theory;
  };
  // Slopes of 0.2 are beyond the first order of the closed form.
  for (const Case& c : {Case{kSmooth, R"({"centre": "centroid"})", "geometric"}, Case{wide, "{}", "rays"}}) {
    const auto study = [&](const std::string& target) {
      return parse_study(text_of(c.psd, target, c.trace, circle, R"(, "terms": {"zernike": {"n_max": 8}})"),
                         "study.json");
    };
    // Only the focus is used, because such wide scatter leaves no planes beside it.
    const ordered_json result = check(study(R"({"statistics": {"ee50": {}}})"));
    EXPECT_EQ(result["scene"]["theory"], c.theory);
    EXPECT_EQ(result["scene"]["needed"], "waves");
    EXPECT_TRUE(warns(result, "theory-fallback"));
    EXPECT_TRUE(warns(result, "rays-not-valid"));
    const std::string error = error_of([&] { check(study(R"({"theory": "ghs"})")); });
    EXPECT_NE(error.find("/target/theory"), std::string::npos) << error;
  }
}

TEST(ModelOfAStudy, EveryApertureAndMirrorHasItsTargetsInLight) {
  const std::string polygon =
      R"({"shape": "polygon", "vertices": [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]})";
  const std::string circle = R"({"shape": "circle", "diameter": "0.4 m"})";
  const auto scene = [&](const std::string& aperture, const std::string& conic) {
    const std::string few = R"({"statistics": {"ee50": {}, "ee90": {}}})";
    return check(parse_study(text_of(kSmooth, few, "{}", aperture, "", conic), "study.json"))["scene"];
  };
  const ordered_json round = scene(circle, "-1"), square = scene(polygon, "-1"), bent = scene(circle, "-0.9");
  for (const ordered_json& s : {round, square, bent}) EXPECT_EQ(s["theory"], "ghs");
  EXPECT_NE(square["ghs"]["ee50_radius_m"], round["ghs"]["ee50_radius_m"]);
  EXPECT_NE(bent["ghs"]["ee50_radius_m"], round["ghs"]["ee50_radius_m"]);  // not the values of a parabola
}

TEST(ModelOfAStudy, RaysAreTakenWithinAThirdOfTheMargin) {
  const auto needed = [](const std::string& margin) {
    const std::string rest = R"(, "equivalence": {"margin": ")" + margin + "\"}";
    const ordered_json result = check(parse_study(
        text_of(kRough, "{}", "{}", R"({"shape": "circle", "diameter": "0.4 m"})", rest), "study.json"));
    return result["scene"]["needed"].get<std::string>();
  };
  const ModelChoice choice = choose_model(RadialPsd(UniformPsd{200e-9, 2.5, 13}), Mirror{kFocal, -1, {}},
                                          CircleAperture{kDiameter}, kLambda, HUGE_VAL);
  ASSERT_GT(choice.ray_error, 0.004);
  ASSERT_LT(choice.ray_error, 0.1);
  EXPECT_EQ(needed(std::to_string(330 * choice.ray_error) + " %"), "rays");
  EXPECT_EQ(needed(std::to_string(270 * choice.ray_error) + " %"), "waves");
}

// The closed form of the geometric theory needs a rotationally symmetric mirror. Other mirrors use random
// deflections of the same theory, and a study that names the closed form is refused.
TEST(ModelOfAStudy, KnownZernikesWithoutSymmetryTakeDrawnRays) {
  const auto study = [](const std::string& noll, const std::string& target) {
    ordered_json text = ordered_json::parse(text_of(kRough, target));
    text["mirror"]["zernike"] = {{"noll", ordered_json::parse(noll)}};
    return parse_study(text.dump(), "study.json");
  };
  const std::string paper = R"({"convention": "paper"})";
  EXPECT_EQ(check(study(R"({"4": "300 nm", "11": "50 nm"})", paper))["scene"]["theory"], "geometric");
  const std::string one = R"({"statistics": {"ee90": {"value": "80 um"}}})";
  EXPECT_EQ(check(study(R"({"4": "300 nm", "6": "50 nm"})", one))["scene"]["theory"], "given");
  const std::string without = R"({"4": "300 nm", "6": "150 nm"})";
  const ordered_json result = check(study(without, R"({"convention": "paper"})"));
  EXPECT_EQ(result["scene"]["theory"], "rays");
  EXPECT_EQ(result["scene"]["model"], "rays");
  EXPECT_EQ(result["study"]["mirror"]["zernike"]["noll"]["6"], 150e-9);
  const std::string error = error_of([&] { check(study(without, R"({"theory": "geometric"})")); });
  EXPECT_NE(error.find("/target/theory"), std::string::npos) << error;
  EXPECT_NE(error.find("\"rays\", the same theory"), std::string::npos) << error;
  EXPECT_NO_THROW(check(study(without, R"({"theory": "rays"})")));
}

TEST(ModelOfAStudy, AnRmsRadiusExistsForRaysOnly) {
  const std::string statistics = R"("statistics": {"rms_radius": {}}})";
  const std::string error = error_of([&] { check(study_of(kSmooth, R"({"theory": "ghs", )" + statistics)); });
  EXPECT_NE(error.find("/target/statistics/rms_radius"), std::string::npos) << error;
  EXPECT_NE(error.find("infinite"), std::string::npos) << error;
  EXPECT_NO_THROW(check(study_of(kRough, R"({"theory": "geometric", )" + statistics)));
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
    // The height lacks the mean over the aperture: int f (2 J1(x)/x)^2 df, x = pi f D, of the uniform band.
    EXPECT_NEAR(target["rms_height_m"].get<double>() / (200e-9 * std::sqrt(1 - 0.00210172)), 1, 1e-5);
    // Slopes are geometric under every theory: sqrt2 2 s, s = pi sigma sqrt(f_max^2 + f_min^2), less 0.13 %
    // for the aperture at f/7. Perturbed rays add sampling errors.
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
  EXPECT_DOUBLE_EQ(scene["tis"].get<double>(), ghs.tis());
  EXPECT_NEAR(scene["tis"].get<double>(), 1 - std::exp(-g * g), 1e-3);  // at normal incidence
  EXPECT_NEAR(scene["ghs"]["core_share"].get<double>(), 1 - ghs.tis(), 1e-12);
  const double slope = std::numbers::pi * 25.18e-9 * std::hypot(2.5, 19.96);
  // Exact rays over the aperture are wider than 2 f slope sqrt(2 ln 10) by 1/(32 N^2).
  const double rays = scene["rays_ee90_radius_m"].get<double>();
  const double paraxial = std::sqrt(2 * std::numbers::ln10) * 2 * kFocal * slope;
  EXPECT_NEAR(rays / paraxial - 1, std::pow(kDiameter / kFocal, 2) / 32, 2e-6);
  EXPECT_NEAR(scene["model_error"]["ray_ee90"].get<double>(), rays / ee90 - 1, 1e-9);
  EXPECT_EQ(scene["model_error"].size(), 2u);
  EXPECT_NEAR(scene["paper_ratio_r"].get<double>(), 1.84, 0.01);  // a quarter of the R of 100 nm
}

// All numbers with the key `tis`.
void collect_tis(const ordered_json& json, std::vector<double>* found) {
  for (const auto& item : json.items()) {
    if (json.is_object() && item.key() == "tis" && item.value().is_number())
      found->push_back(item.value().get<double>());
    if (item.value().is_structured()) collect_tis(item.value(), found);
  }
}

// An f/0.8 mirror with 17 degrees of incidence at the rim; a sphere; fine roughness; a slow mirror.
TEST(Check, TisIsOneNumberOfOneResult) {
  for (
      const char* scene :
      {R"("mirror": {"focal_length": "0.32 m"}, "roughness": {"psd": {"model": "k-correlation", "rms": "30 nm",
            "B": "20 mm", "exponent": 3, "f_min": "5 /m", "f_max": "100 /m"}})",
       R"("mirror": {"focal_length": "4 m", "conic": 0}, "roughness": {"psd": {"model": "uniform",
            "rms": "12 nm", "f_min": "5 /m", "f_max": "50 /m"}})",
       R"("mirror": {"focal_length": "0.6 m"}, "roughness": {"psd": {"model": "uniform", "rms": "40 nm",
            "f_min": "1000 /m", "f_max": "100000 /m"}})",
       R"("mirror": {"focal_length": "20 m"}, "roughness": {"psd": {"model": "power-law", "rms": "9 nm",
            "exponent": 2.2, "f_min": "5 /m", "f_max": "200 /m"}})"}) {
    const Study study = parse_study(
        R"({"aberfit": 1, "aperture": {"shape": "circle", "diameter": "0.4 m"},
            "light": {"wavelength": "632.8 nm"}, "target": {"theory": "ghs", "statistics": {"ee80": {}}}, )" +
            std::string(scene) + "}",
        "study.json");
    const ordered_json result = check(study);
    std::vector<double> found;
    collect_tis(result["scene"], &found);
    ASSERT_GE(found.size(), 2u) << scene;
    for (const double tis : found) EXPECT_EQ(tis, found[0]) << scene;
    EXPECT_NEAR(result["scene"]["ghs"]["core_share"].get<double>(), 1 - found[0], 1e-15);
  }
}

}  // namespace
}  // namespace aberfit
