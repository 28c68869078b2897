#include "aberfit/report/result.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "aberfit/report/documents.h"
#include "sample_result.h"

using namespace aberfit;
using Json = nlohmann::ordered_json;

namespace {

std::vector<std::string> keys(const Json& object) {
  std::vector<std::string> names;
  for (const auto& [key, value] : object.items()) names.push_back(key);
  return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST(ResultDocument, HasTheKeysOfFormatVersionOneInTheirOrder) {
  const Json json = to_json(sample_result(), sample_study());
  EXPECT_EQ(keys(json), (Names{"aberfit", "kind", "study", "headline", "scene", "target", "fit",
                               "coefficients", "statistics", "equivalence", "warnings", "provenance"}));
  EXPECT_EQ(json["aberfit"], 1);
  EXPECT_EQ(json["kind"], "fit");
  for (const char* key :
       {"rms_height_m", "rms_slope_per_axis", "n_eff", "g", "kappa", "paper_ratio_r", "model", "reason"})
    EXPECT_TRUE(json["scene"].contains(key)) << key;
  for (const char* key : {"status", "message", "iterations", "evaluations", "seconds", "initial_cost",
                          "final_cost", "rank", "terms", "pupil_points", "equivalent_surface"})
    EXPECT_TRUE(json["fit"].contains(key)) << key;
  for (const char* key :
       {"name", "held_out", "target", "model", "relative_difference", "interval", "margin", "verdict"})
    EXPECT_TRUE(json["equivalence"]["metrics"][0].contains(key)) << key;
  EXPECT_EQ(keys(json["target"]["ee90_radius_m"]), (Names{"value", "standard_error", "tolerance"}));
  EXPECT_EQ(keys(json["coefficients"]["zernike"][0]), (Names{"n", "m", "noll", "value_m", "std_m"}));
  EXPECT_EQ(keys(json["provenance"]), (Names{"version", "commit", "inputs", "seed", "threads", "libraries"}));
}

TEST(ResultDocument, CarriesTheCharacterOfASurface) {
  ResultDocument result = sample_result();
  result.judgement.character = sample_character();
  const Json json = to_json(result, sample_study());
  const Json& character = json["character"];
  EXPECT_EQ(character["of_this_roughness"], false);
  EXPECT_EQ(character["psd_ratio"][1]["f_high_per_m"], 12);
  EXPECT_EQ(character["psd_ratio"][1]["value"], 3.1);
  EXPECT_EQ(character["zones"][1]["value"], 1.25);
  EXPECT_EQ(character["zones"][1]["inside"], false);
  EXPECT_EQ(character["other_light"][0]["worst_tolerances"], 1.8);
  EXPECT_EQ(character["other_light"][1]["obstacle"], "it has no grid");
}

TEST(ResultDocument, CarriesItsNumbersInSi) {
  const ResultDocument result = sample_result();
  const Json json = to_json(result, sample_study());
  EXPECT_EQ(json["scene"]["rms_height_m"], 100e-9);
  EXPECT_EQ(json["scene"]["theory"], "geometric");
  EXPECT_EQ(json["scene"]["model"], "rays");
  EXPECT_EQ(json["target"]["ee50_radius_m@-1mm"]["value"], 91.9e-6);
  EXPECT_EQ(json["fit"]["status"], to_string(FitStatus::kConverged));
  EXPECT_EQ(json["fit"]["terms"], 10);
  EXPECT_EQ(json["statistics"]["validated"]["ee50_radius_m"], 1.002 * 41.234e-6);
  EXPECT_EQ(json["statistics"]["start"]["rms_height_m"], 1.1 * 100e-9);
  EXPECT_EQ(json["equivalence"]["verdict"], "different");
  EXPECT_EQ(json["equivalence"]["metrics"][6]["held_out"], true);
  EXPECT_EQ(json["warnings"][0]["code"], "realisation-spread");
  // Noll 1976, table 1: (2,-2) is 5, (2,0) is 4, (2,2) is 6, (3,1) is 8.
  const int noll[] = {5, 4, 6, 8};
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(json["coefficients"]["zernike"][i]["noll"], noll[i]);
    EXPECT_EQ(json["coefficients"]["zernike"][i]["value_m"], result.fitted.fit.coefficients[i]);
  }
  EXPECT_EQ(json["coefficients"]["fourier"][1]["fx_per_m"], -7.25);
  EXPECT_EQ(json["coefficients"]["fourier"][1]["sin_m"], result.fitted.fit.coefficients[7]);
  EXPECT_EQ(json["coefficients"]["spherical"]["c8"]["value_m"], result.fitted.fit.coefficients[9]);
  // c8 rho^8 is the value at rho = 0.2 m, so c8 = value / 2.56e-6 m^8; the power costs a few roundings.
  EXPECT_NEAR(json["coefficients"]["spherical"]["c8"]["coefficient"].get<double>() /
                  (result.fitted.fit.coefficients[9] / 2.56e-6),
              1.0, 1e-15 * 8);
}

TEST(ResultDocument, SaysHowTheSurfaceWasComputed) {
  ResultDocument result = sample_result();
  result.fitted.fit.operator_choice.zernike = ZernikeMethod::kPolar;
  result.fitted.fit.operator_choice.reason = "rings";
  const Json json = to_json(result, sample_study())["fit"]["operator"];
  EXPECT_EQ(json["zernike"], "polar");
  EXPECT_TRUE(json["fourier"].is_null());
  EXPECT_EQ(json["reason"], "rings");
}

TEST(ResultDocument, WritesWhatDoesNotExistAsNull) {
  ResultDocument result = sample_result();
  result.scene.numbers.correlation_length = std::numeric_limits<double>::infinity();
  const Json json = to_json(result, sample_study());
  EXPECT_TRUE(json["statistics"]["validated"]["ring_fwhm_m"].is_null());
  EXPECT_TRUE(json["scene"]["correlation_length_m"].is_null());
  EXPECT_TRUE(json["equivalence"]["metrics"][3]["model"].is_null());
  EXPECT_TRUE(json["equivalence"]["metrics"][3]["interval"][0].is_null());
  EXPECT_EQ(json["equivalence"]["metrics"][3]["verdict"], "different");
  // A NaN left in memory would be written as null and differ here; every number reads back to the same bits.
  EXPECT_EQ(Json::parse(json.dump()), json);
}

TEST(ResultDocument, KeepsBothOfTwoTargetsWithOneName) {
  const Json target = to_json(sample_result(), sample_study())["target"];
  EXPECT_EQ(target.size(), sample_result().fitted.targets.size());
  EXPECT_EQ(target["ring_through"]["value"], 0.9);
  EXPECT_EQ(target["ring_through#2"]["value"], 0.6);
}

TEST(ResultDocument, WithoutAFitHasNothingToShowOfIt) {
  ResultDocument trace;
  trace.fitted.targets = {{ScatterRms{}, std::nan(""), 0.0, 1.0}};
  trace.fitted.values = Eigen::VectorXd::Constant(1, 3e-5);
  const Json json = to_json(trace, sample_study());
  EXPECT_TRUE(json["scene"].is_null());
  EXPECT_TRUE(json["target"]["scatter_rms_rad"]["value"].is_null());
  EXPECT_EQ(keys(json["statistics"]), Names{"fitted"});
  EXPECT_EQ(json["fit"]["status"], to_string(FitStatus::kNotRun));
  EXPECT_TRUE(json["coefficients"].empty());
}

TEST(Provenance, NamesVersionsOfEverythingThatTookPart) {
  const Provenance provenance = make_provenance(42, 3);
  EXPECT_EQ(provenance.seed, 42u);
  EXPECT_EQ(provenance.threads, 3);
  EXPECT_EQ(std::count(provenance.version.begin(), provenance.version.end(), '.'), 2);
  for (const char* name : {"eigen", "boost", "nlohmann-json", "fmt"}) {
    ASSERT_TRUE(provenance.libraries.contains(name)) << name;
    const std::string version = provenance.libraries.at(name);
    EXPECT_EQ(std::count(version.begin(), version.end(), '.'), 2) << name << " " << version;
    EXPECT_EQ(version.find_first_not_of("0123456789."), std::string::npos) << name << " " << version;
  }
  EXPECT_FALSE(provenance.libraries.at("compiler").empty());
}
