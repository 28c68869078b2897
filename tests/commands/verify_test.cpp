#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/report/verify_report.h"
#include "aberfit/study/published.h"
#include "aberfit/study/read_study.h"
#include "study/run_program.h"
#include "study/scratch_folder.h"

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

namespace {

// What the shipped study gives, with its pictures; made once for the suite.
class PaperVerify : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::ScratchFolder;
    RunOptions options;
    options.threads = 2;
    options.output_directory = folder_->file("out");
    study_ = new Study(read_study(kStudy));
    report_ = new VerifyReport(run_verify(*study_, options));
  }
  static void TearDownTestSuite() {
    delete report_;
    delete study_;
    delete folder_;
  }
  static nlohmann::ordered_json json() { return to_json(*report_, resolved_study(*study_)); }

  static inline test::ScratchFolder* folder_ = nullptr;
  static inline Study* study_ = nullptr;
  static inline VerifyReport* report_ = nullptr;
};

// One row of the list of the paper's numbers.
struct Listed {
  std::string id, section, kind, label, value, unit, what, note;
};
std::vector<Listed> listed_numbers() {
  std::ifstream file(ABERFIT_TEST_DATA "/paper/numbers.csv");
  std::vector<Listed> rows;
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> cells(1);
    bool quoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
      if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
        cells.back() += line[i++];
      else if (line[i] == '"')
        quoted = !quoted;
      else if (line[i] == ',' && !quoted)
        cells.emplace_back();
      else
        cells.back() += line[i];
    }
    EXPECT_EQ(cells.size(), 8u) << line;
    if (cells.size() == 8 && cells[0] != "id")
      rows.push_back({cells[0], cells[1], cells[2], cells[3], cells[4], cells[5], cells[6], cells[7]});
  }
  return rows;
}
// Its verdict: the first word of the note, as results write it.
std::string verdict_of(const Listed& row) {
  std::string word = row.note.substr(0, row.note.find_first_of(" .,:;"));
  for (char& c : word) c = char(std::tolower(static_cast<unsigned char>(c)));
  return word;
}

}  // namespace

TEST_F(PaperVerify, IsEquivalentByRaysAndInLight) {
  EXPECT_EQ(report_->verdict, Verdict::kEquivalent);
  EXPECT_TRUE(report_->rays_decide);  // the study names the geometric theory
  EXPECT_EQ(report_->light_verdict, Verdict::kEquivalent);
  EXPECT_GT(report_->draws, 100);
  const auto result = json();
  EXPECT_EQ(result["headline"], "EQUIVALENT in geometric rays; in light EQUIVALENT");
  EXPECT_EQ(result["decided_by"], "rays");
  EXPECT_NE(summary_table(*report_).find("\n\nEQUIVALENT in geometric rays; in light EQUIVALENT\n"),
            std::string::npos);
  EXPECT_EQ(nlohmann::ordered_json::parse(test::read_file(folder_->file("out/result.json"))), result);
  EXPECT_EQ(test::read_file(folder_->file("out/summary.txt")), summary_table(*report_));
  // Theory in closed form against its own rays, and light's theory against waves: within 4.5 standard errors.
  for (std::size_t k = 0; k < report_->metrics.size(); ++k) {
    const EquivalenceMetric& m = report_->metrics[k];
    EXPECT_NEAR(m.target / report_->theory[k], 1, 4.5 * m.standard_error) << m.name;
    EXPECT_NEAR(m.relative_difference, 0, 4.5 * m.standard_error) << m.name;
    EXPECT_LT(m.standard_error, 0.004) << m.name;  // what makes a margin of 1 % decidable
  }
  // Intervals of means of 16 groups: Student's t with 15 degrees of freedom, one-sided 95 % (1.753, not the
  // 1.645 of a known error).
  for (const auto* metrics : {&report_->metrics, &report_->light})
    for (const EquivalenceMetric& m : *metrics)
      EXPECT_NEAR((m.interval[1] - m.interval[0]) / 2 / m.standard_error, 1.753050356, 1e-6) << m.name;
  ASSERT_GE(report_->light.size(), 8u);
  for (const EquivalenceMetric& m : report_->light) {
    EXPECT_NEAR(m.relative_difference, 0, 4.5 * m.standard_error) << m.name;
    EXPECT_LT(m.standard_error, 0.005) << m.name;
  }
}

TEST_F(PaperVerify, ReproducesThePaper) {
  const auto result = json();
  const auto& q = result["quantities"];
  // Ensemble means against closed forms of PHYSICS 5.
  EXPECT_NEAR(q["harvey_shack.ee90_radius_m"].get<double>() / 75.55e-6, 1.0, 0.002);
  EXPECT_NEAR(q["harvey_shack.ring_fwhm_m"].get<double>() / 2.967e-3, 1.0, 0.002);
  EXPECT_NEAR(q["harvey_shack.scatter_mean_rad"].get<double>() / 1.574e-5, 1.0, 0.002);
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
  // Deflections as vectors: z component D R/(f sqrt2) with the printed D (PHYSICS 9), to the noise of 15,000
  // rays; the mean vector over the mean magnitude is noise of order 1/sqrt(N).
  EXPECT_NEAR(q["harvey_shack.deflection_std_z"].get<double>() / 6.334e-7, 1.0, 0.03);
  EXPECT_LT(q["harvey_shack.mean_to_mean_deflection"].get<double>(), 4.5 / std::sqrt(15000.0));
}

TEST_F(PaperVerify, AnswersEveryNumberOfThePaper) {
  std::map<std::string, const PublishedComparison*> answer;
  for (const PublishedComparison& row : report_->published) {
    EXPECT_FALSE(row.reading.empty()) << row.label;
    EXPECT_FALSE(row.verdict.empty()) << row.label;
    if (row.id.empty()) continue;
    EXPECT_TRUE(answer.emplace(row.id, &row).second) << row.id << " twice";
  }
  const std::vector<Listed> list = listed_numbers();
  ASSERT_EQ(list.size(), 195u);
  for (const Listed& row : list) {
    SCOPED_TRACE(row.id);
    ASSERT_TRUE(answer.contains(row.id));
    const PublishedComparison& ours = *answer[row.id];
    EXPECT_EQ(ours.printed_text, row.value);  // digit for digit
    EXPECT_EQ(ours.section, row.section);
    EXPECT_FALSE(ours.derived);
    EXPECT_EQ(ours.verdict, verdict_of(row));
    EXPECT_EQ(row.kind == "figure" && ours.picture.empty(), false);
  }
  EXPECT_EQ(answer.size(), list.size());
  // Where the paper prints a number and something can be computed, it is: rows without ours are inputs, what
  // is not stated, words and pictures.
  int computed = 0;
  for (const auto& [id, row] : answer) computed += int(std::isfinite(row->ours));
  EXPECT_GE(computed, 110);
  EXPECT_EQ(answer["hs-gradient-theory"]->verdict, "not-reproducible");
}

TEST_F(PaperVerify, DerivedNumbersAreCalledSo) {
  const std::string table = summary_table(*report_);
  std::set<std::string> derived;
  for (const PublishedComparison& row : report_->published)
    if (row.derived) derived.insert(row.printed_text);
  for (const char* number : {"3.31", "2.73", "0.0577", "3.183e-27"}) {
    EXPECT_TRUE(derived.contains(number)) << number;
    EXPECT_NE(
        table.find(std::string(number) + (number == std::string("3.183e-27") ? " m^4" : "") + " (derived)"),
        std::string::npos)
        << number;
  }
  // A direction component has no unit; the RMS of the terms is printed in radians.
  for (const PublishedComparison& row : report_->published) {
    if (row.id == "hs-deflection-std-z") {
      EXPECT_EQ(row.unit, "");
    } else if (row.id == "at-scatter-rms") {
      EXPECT_EQ(row.unit, "rad");
    } else if (row.id == "hs-bias") {
      // The printed mean vector over the Rayleigh mean of the printed gradients.
      const double per_axis = 632.8e-9 / (4 * std::acos(-1.0)) * std::hypot(244.3, 253.7) / std::sqrt(2.0);
      EXPECT_NEAR(row.ours,
                  std::hypot(7.41e-8, 1.47e-7, 1.48e-10) / (std::sqrt(std::acos(-1.0) / 2) * per_axis),
                  1e-12);
      EXPECT_NEAR(row.ours, golden_arithmetic().at("bias_ratio"), 2e-6);
    }
  }
}

TEST_F(PaperVerify, DrawsEveryFigure) {
  for (const std::string& name : verify_picture_names())
    EXPECT_TRUE(std::filesystem::exists(folder_->file("out/plots/" + name + ".gp"))) << name;
  std::set<std::string> named;
  for (const PublishedComparison& row : report_->published) named.insert(row.picture);
  named.erase("");
  EXPECT_EQ(named.size(), verify_picture_names().size()) << "a picture that answers nothing";
  bool drawn = true;
  for (const Warning& warning : report_->warnings) drawn = drawn && warning.code != "no-gnuplot";
  if (!drawn) GTEST_SKIP() << "no gnuplot here";
  for (const std::string& name : named)
    EXPECT_GT(std::filesystem::file_size(folder_->file("out/plots/" + name + ".png")), 10000u) << name;
}

namespace {

// The shipped study without what takes long.
Study short_study(int draws) {
  Study study = read_study(kStudy);
  study.verify.published.clear();
  study.verify.aside = {};
  study.verify.aside.draws = draws;
  return study;
}

}  // namespace

// The decision on ensemble means: terms that cannot carry the roughness are found out, by rays and in light.
TEST(Verify, TermsThatCannotCarryTheRoughnessAreDifferent) {
  Study study = short_study(64);
  study.terms.zernike->n_max = 12;  // 13/(2 pi R) = 10 of 40 cycles/m
  const VerifyReport report = run_verify(study, {});
  EXPECT_EQ(report.verdict, Verdict::kDifferent);
  EXPECT_EQ(report.rays_verdict, Verdict::kDifferent);
  EXPECT_EQ(report.light_verdict, Verdict::kDifferent);
  EXPECT_EQ(report.draws, 64);
}

TEST(Verify, FewDrawsDecideNothingAndSaySo) {
  const VerifyReport report = run_verify(short_study(16), {});
  EXPECT_EQ(report.verdict, Verdict::kUndecided);
  bool warned = false;
  for (const Warning& warning : report.warnings) warned = warned || warning.code == "few-draws";
  EXPECT_TRUE(warned);
}

// Light decides where the study does not name rays; there its answer is of waves.
TEST(Verify, LightDecidesUnlessTheStudyNamesRays) {
  Study study = short_study(64);
  study.target = {};
  study.psd = PsdModel(UniformPsd{25.18e-9, 2.5, 19.96});
  study.terms.zernike->n_max = 30;
  study.equivalence.margin = 0.05;
  const VerifyReport report = run_verify(study, {});
  EXPECT_FALSE(report.rays_decide);
  EXPECT_EQ(report.verdict, report.light_verdict);
  EXPECT_EQ(report.light_verdict, Verdict::kEquivalent);
  EXPECT_EQ(to_json(report, {})["decided_by"], "light");
  for (const EquivalenceMetric& m : report.light)
    EXPECT_NEAR(m.relative_difference, 0, 4.5 * m.standard_error) << m.name;
}

TEST(Verify, TheSameBitsForAnyNumberOfThreads) {
  RunOptions one, two;
  one.threads = 1;
  two.threads = 2;
  EXPECT_EQ(to_json(run_verify(short_study(16), one), {}).dump(),
            to_json(run_verify(short_study(16), two), {}).dump());
}

TEST(Verify, NamesWhatDoesNotExist) {
  const auto error_of = [](auto change) {
    Study study = short_study(16);
    study.verify.published.resize(1);
    study.verify.published[0].label = "a row";
    change(study.verify.published[0]);
    try {
      run_verify(study, {});
    } catch (const InputError& error) {
      return error.pointer() + ": " + error.allowed();
    }
    return std::string("accepted");
  };
  const std::string quantity = error_of([](PublishedNumber& row) { row.quantity = "harvey_shack.ee90"; });
  EXPECT_TRUE(quantity.starts_with("/verify/published/0/quantity: ")) << quantity;
  EXPECT_NE(quantity.find("harvey_shack.ee90_radius_m"), std::string::npos) << quantity;
  const std::string name = error_of([](PublishedNumber& row) { row.expression = "2*printed.nobody"; });
  EXPECT_TRUE(name.starts_with("/verify/published/0/expression: ")) << name;
  const std::string picture = error_of([](PublishedNumber& row) { row.picture = "portrait"; });
  EXPECT_TRUE(picture.starts_with("/verify/published/0/picture: ")) << picture;
  EXPECT_NE(picture.find("ring_through"), std::string::npos) << picture;
}
