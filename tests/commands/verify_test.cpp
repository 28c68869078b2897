#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/report/verify_report.h"
#include "aberfit/study/published.h"
#include "aberfit/study/read_study.h"

using namespace aberfit;

namespace {

const std::string kStudy = ABERFIT_SOURCE_DIR "/fits/paper-verify/study.json";

// Name -> value of the recomputed arithmetic of the paper (first two columns).
std::map<std::string, double> golden_arithmetic() {
  std::ifstream file(ABERFIT_TEST_DATA "/golden/arithmetic.csv");
  std::map<std::string, double> values;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#' || line.starts_with("name")) continue;
    std::istringstream row(line);
    std::string name, value;
    std::getline(row, name, ',');
    std::getline(row, value, ',');
    values[name] = std::stod(value);
  }
  return values;
}

FormulaInputs gradients() {
  FormulaInputs inputs;
  inputs.gradient_x = 244.3;
  inputs.gradient_y = 253.7;
  return inputs;
}

}  // namespace

TEST(PublishedFormulas, MatchTheRecomputedArithmetic) {
  const Study study = read_study(kStudy);
  const std::map<std::string, double> golden = golden_arithmetic();
  ASSERT_GT(golden.size(), 15u);
  const auto check = [&](const std::string& formula, FormulaInputs inputs, const std::string& name,
                         double unit = 1.0) {
    EXPECT_NEAR(evaluate_formula(formula, inputs, study) / unit / golden.at(name), 1.0, 1e-6) << formula;
  };
  const double arcsec = std::acos(-1.0) / 180 / 3600;
  check("total_gradient", gradients(), "grad_total");
  check("deflection_x", gradients(), "deflection_std_x");
  check("deflection_y", gradients(), "deflection_std_y");
  check("mean_deflection", gradients(), "mean_magnitude_rayleigh");
  check("mean_deflection", gradients(), "mean_magnitude_arcsec", arcsec);
  check("rms_deflection", gradients(), "rms_magnitude");
  check("focal_shift_std", gradients(), "z_std");
  FormulaInputs band;
  band.rms = 1e-7;
  band.f_min = 2.5;
  band.f_max = 1e6;
  check("largest_angle", band, "theta_max_arcsec", arcsec);
  check("uniform_psd_2d", band, "P0_2d_m4");
  check("uniform_psd_1d", band, "P0_1d_m3");
  check("uniform_slope_total", band, "slope_total_2d");
  FormulaInputs ratio;
  ratio.rms = 1e-9;
  ratio.correlation_length = 1e-6;
  ratio.wavelength = 500e-9;
  ratio.diameter = 0.2;
  check("paper_ratio_r", ratio, "R_table_1nm_1um_0.2");
  EXPECT_TRUE(std::isnan(evaluate_formula("paper_ratio_r", {}, study)));  // inputs that nobody gave
}

TEST(Verify, ReproducesThePaper) {
  RunOptions options;
  options.threads = 2;
  const Study study = read_study(kStudy);
  const VerifyReport report = run_verify(study, options);
  const std::string table = summary_table(report);
  const nlohmann::ordered_json result = to_json(report, resolved_study(study));
  const auto& q = result["quantities"];
  // Sampling of 15,000 random rays (PHYSICS 2): 0.51 % on ee90, 0.7 % on the ring width, 0.4 % on the
  // scatter; 4.5 standard errors.
  EXPECT_NEAR(q["harvey_shack.ee90_radius_m"].get<double>() / 75.55e-6, 1.0, 4.5 * 0.0051);
  EXPECT_NEAR(q["harvey_shack.ring_fwhm_m"].get<double>() / 2.967e-3, 1.0, 4.5 * 0.007);
  EXPECT_NEAR(q["harvey_shack.scatter_mean_rad"].get<double>() / 1.574e-5, 1.0, 4.5 * 0.0043);
  // Counts of 0.1 mm samples: 2.9 mm, one sample more or less with the sampling; 0.3 mm exactly.
  EXPECT_NEAR(q["harvey_shack.ring_fwhm_counted_m"].get<double>(), 2.9e-3, 1.01e-4);
  EXPECT_NEAR(q["ideal.ring_fwhm_counted_m"].get<double>(), 3e-4, 1e-9);
  EXPECT_NEAR(q["ideal.ring_fwhm_m"].get<double>() / 3.95979797e-4, 1.0, 0.01);
  EXPECT_LT(q["ideal.ee90_radius_m"].get<double>(), 1e-14);
  // The published formulas: expectation in closed form, 367 rad/m and 4.2 pm (PHYSICS 9).
  EXPECT_NEAR(q["published_phase.gradient_expected_rad_per_m"].get<double>(), 367, 0.5);
  EXPECT_NEAR(q["published_phase.surface_rms_height_m"].get<double>() / 4.159e-12, 1.0,
              0.15);  // about 200 modes carry it
  // Independent coefficients, the candidate reading: 54.4 um, 2.56 mm, 3.18 arcsec in the ensemble mean of
  // 200 draws.
  EXPECT_NEAR(q["independent_terms.ee90_radius_m"].get<double>() / 54.4e-6, 1.0, 0.02);
  EXPECT_NEAR(q["independent_terms.ring_fwhm_m"].get<double>() / 2.56e-3, 1.0, 0.02);
  EXPECT_NEAR(q["independent_terms.scatter_rms_rad"].get<double>() / (3.18 * 4.84813681e-6), 1.0, 0.02);
  // Every row has a value of ours, or is there to say that none exists.
  for (const auto& row : result["published"]) {
    EXPECT_FALSE(row["reading"].get<std::string>().empty());
    if (row["ours"].is_null()) {
      EXPECT_NE(row["reading"].get<std::string>().find("Not reproducible"), std::string::npos) << row;
    }
  }
  EXPECT_NE(table.find("reading"), std::string::npos);
}

TEST(Verify, NamesAQuantityThatDoesNotExist) {
  Study study = read_study(kStudy);
  study.verify.published.resize(1);
  study.verify.published[0].formula.clear();
  study.verify.published[0].quantity = "harvey_shack.ee90";
  study.verify.aside.published_phase.reset();
  study.verify.aside.independent_terms.reset();
  try {
    run_verify(study, {});
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.pointer(), "/verify/published/0/quantity");
    EXPECT_NE(error.allowed().find("harvey_shack.ee90_radius_m"), std::string::npos);
  }
}
