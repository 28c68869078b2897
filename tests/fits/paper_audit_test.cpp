// Every number, claim and figure of the paper is computed anew and compared with its verdict in
// tests/data/paper/numbers.csv. The results of `aberfit verify` on the paper's scene are tested, too.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "aberfit/commands/run.h"
#include "aberfit/report/verify_report.h"
#include "aberfit/study/read_study.h"
#include "fits/paper_formulas.h"
#include "fits/paper_page.h"
#include "shared_data.h"
#include "study/run_program.h"
#include "study/scratch_folder.h"

using namespace aberfit;
using namespace aberfit::test;

namespace {

const std::string kFolder = ABERFIT_SOURCE_DIR "/fits/paper-verify/";

// Values of the paper's recomputed arithmetic by name (first two columns).
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

// Results of the paper's study, with pictures. They are computed once for the suite.
class PaperAudit : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new ScratchFolder;
    RunOptions options;
    options.threads = 2;
    options.output_directory = folder_->file("out");
    study_ = new Study(read_study(kFolder + "study.json"));
    report_ = new VerifyReport(run_verify(*study_, options));
    paper_ = new Paper(*study_, *report_, options.threads);
    for (const PaperNumber& row : paper_->numbers) answers_[row.id] = answer_to(row);
  }
  static void TearDownTestSuite() {
    answers_.clear();
    delete paper_;
    delete report_;
    delete study_;
    delete folder_;
  }
  static PaperAnswer answer_to(const PaperNumber& row) {
    PaperAnswer answer{row, std::nan("")};
    if (row.formula.empty()) return answer;
    const double si = paper_formula(*paper_, row);
    answer.ours = si / row.si;
    answer.compared = row.within == "condition" || std::isfinite(row.value());
    if (answer.compared)
      answer.holds = row.within == "condition"
                         ? kPaperConditions.at(row.id)(*paper_, si, row.value() * row.si)
                         : agrees(row, answer.ours);
    return answer;
  }
  static double ours(const std::string& id) { return answers_.at(id).ours; }

  static inline ScratchFolder* folder_ = nullptr;
  static inline Study* study_ = nullptr;
  static inline VerifyReport* report_ = nullptr;
  static inline Paper* paper_ = nullptr;
  static inline std::map<std::string, PaperAnswer> answers_;
};

}  // namespace

TEST_F(PaperAudit, EveryNumberHoldsOrFailsAsTheListSays) {
  const std::set<std::string> words = {"holds",      "fails",   "reading",          "input",
                                       "not-stated", "picture", "not-reproducible", "untested"};
  int numbers = 0, computed = 0, conditions = 0;
  std::set<std::string> formulas;
  for (const PaperNumber& row : paper_->numbers) {
    SCOPED_TRACE(row.id);
    const PaperAnswer& answer = answers_.at(row.id);
    EXPECT_TRUE(words.contains(row.verdict)) << row.verdict;
    EXPECT_FALSE(row.reading.empty());
    EXPECT_EQ(std::isfinite(answer.ours), !row.formula.empty());
    EXPECT_TRUE(!answer.compared || answer.holds == (row.verdict != "fails"))
        << answer.ours << " against " << row.printed;
    conditions += int(row.within == "condition");
    formulas.insert(row.formula);
    if (row.kind == "derived" || row.kind == "reading") continue;
    ++numbers;
    computed += int(std::isfinite(answer.ours));
  }
  EXPECT_EQ(answers_.size(), paper_->numbers.size()) << "two rows with one id";
  EXPECT_EQ(numbers, 195);
  // Rows without a value of ours are inputs, unstated numbers, words and pictures.
  EXPECT_GE(computed, 110);
  EXPECT_EQ(conditions, int(kPaperConditions.size()));
  for (const auto& [name, formula] : kPaperFormulas)
    EXPECT_TRUE(formulas.contains(name)) << name << " belongs to no row";
}

TEST_F(PaperAudit, HoldsToTheLastPrintedDigit) {
  EXPECT_DOUBLE_EQ(half_last_digit("1.57e-5"), 0.005e-5);
  EXPECT_DOUBLE_EQ(half_last_digit("655"), 0.5);
  EXPECT_DOUBLE_EQ(half_last_digit("-1.13e3"), 5);
  EXPECT_DOUBLE_EQ(half_last_digit("2.8"), 0.05);
  EXPECT_TRUE(std::isnan(half_last_digit("about 3")));
  PaperNumber row;
  row.printed = "1.57e-5";
  EXPECT_TRUE(agrees(row, 1.575e-5));  // the bound itself
  EXPECT_FALSE(agrees(row, 1.5751e-5));
  EXPECT_FALSE(agrees(row, 1.5649e-5));
  row.within = "0.02";
  EXPECT_TRUE(agrees(row, 1.6e-5));
  EXPECT_FALSE(agrees(row, 1.61e-5));
}

TEST_F(PaperAudit, ArithmeticIsTheOneRecomputedElsewhere) {
  const std::map<std::string, double> golden = golden_arithmetic();
  const auto check = [&](const std::string& id, const std::string& name) {
    EXPECT_NEAR(ours(id) / golden.at(name), 1, 1e-6) << id;
  };
  check("hs-gradient-rms-total", "grad_total");
  check("hs-deflection-std-x", "deflection_std_x");
  check("hs-deflection-std-y", "deflection_std_y");
  check("hs-deflection-theory", "deflection_theory");
  check("hs-deflection-mean", "mean_magnitude_rayleigh");
  check("hs-scatter-mean-arcsec", "mean_magnitude_arcsec");
  check("hs-scatter-rms", "rms_magnitude");
  check("hs-deflection-std-z", "z_std");
  check("theta-max-arcsec", "theta_max_arcsec");
  check("p0-2d-value", "P0_2d_m4");
  check("p0-1d", "P0_1d_m3");
  check("slope-value", "slope_total_2d");
  check("eq-phase-height", "g_100nm_633");
  check("R-1nm-1um-0.2m", "R_table_1nm_1um_0.2");
  check("R-1nm-1um-0.5m", "R_table_D0.5");
  check("R-1nm-1um-1.0m", "R_table_D1");
  check("main-ratio", "R_main_500nm");
  check("main-ratio-633nm", "R_main_632.8nm");
  check("main-ratio-1mm", "R_main_lc1mm");
  EXPECT_NEAR(ours("hs-bias"), golden.at("bias_ratio"), 2e-6);
  EXPECT_NEAR(paper_->printed_slope() / golden.at("slope_paper_formula"), 1, 1e-6);
}

TEST_F(PaperAudit, ThePapersOwnWaysGiveWhatTheirClosedFormsSay) {
  // The paper counts samples of 0.1 mm: 2.9 mm, one sample more or less by sampling; 0.3 mm exactly.
  EXPECT_NEAR(ours("hs-fwhm"), 2.9, 0.101);
  EXPECT_NEAR(ours("ideal-fwhm"), 0.3, 1e-6);
  EXPECT_NEAR(ours("ideal-fwhm-true") / 0.395979797, 1, 0.01);
  EXPECT_LT(ours("ideal-resolution"), 1e-14);
  EXPECT_NEAR(base_surface(study_->mirror, 0.2, 0.0).height, 3.571e-3, 0.5e-6);  // figure 1
  // The sum as stated gives 367 rad/m and 4.2 pm in the mean over its modes, of which about 200 carry it.
  EXPECT_NEAR(ours("sum-gradient-expected"), 367, 0.5);
  EXPECT_NEAR(ours("sum-height") / 4.159e-3, 1, 0.15);
  // The candidate reading has independent coefficients; this is the mean of 200 realisations.
  EXPECT_NEAR(ours("at-ee90-independent") / 54.4, 1, 0.02);
  EXPECT_NEAR(ours("at-fwhm-independent") / 2.56, 1, 0.02);
  EXPECT_NEAR(ours("at-scatter-independent") / 3.18, 1, 0.02);
  // The z components of the deflections agree within the noise of 15,000 rays; their means are noise.
  const Deflections& d = paper_->deflections;
  EXPECT_NEAR(std::sqrt(d.rms_z * d.rms_z - d.mean_z * d.mean_z) / 6.334e-7, 1, 0.03);
  EXPECT_LT(std::hypot(d.mean_x, d.mean_y, d.mean_z) / d.mean, 4.5 / std::sqrt(15000.0));
}

// Figures 8a to 8d have as many modes in every equal step of log f and of the angle, so their density over
// the plane falls as 1/f^2. Chi squared of 28 x 24 classes has mean 671 and standard deviation 37.
TEST_F(PaperAudit, ModesOfTheSumAreUniformInLogFrequencyAndAngle) {
  constexpr int kSteps = 28, kAngles = 24;
  std::map<int, int> count;
  for (const FourierMode& mode : paper_->sum.modes) {
    const double step = std::log(std::hypot(mode.fx, mode.fy) / PaperSum::kLow) /
                        std::log(PaperSum::kHigh / PaperSum::kLow) * kSteps;
    const double turn = (std::atan2(mode.fy, mode.fx) / std::numbers::pi + 1) / 2 * kAngles;
    ++count[std::clamp(int(step), 0, kSteps - 1) * kAngles + std::clamp(int(turn), 0, kAngles - 1)];
  }
  const double expected = double(PaperSum::kModes) / (kSteps * kAngles);
  double chi = 0;
  for (int cell = 0; cell < kSteps * kAngles; ++cell) chi += std::pow(count[cell] - expected, 2) / expected;
  EXPECT_NEAR(chi, 671, 4 * 37);
}

TEST_F(PaperAudit, ThePageIsWrittenByThisTest) {
  std::vector<PaperAnswer> answers;
  for (const PaperNumber& row : paper_->numbers) answers.push_back(answers_.at(row.id));
  const std::string page = read_file(kFolder + "README.md");
  const std::size_t mark = page.find(kPaperPageMark);
  ASSERT_NE(mark, std::string::npos);
  const std::string by_hand = page.substr(0, mark + std::string(kPaperPageMark).size());
  const std::string now = by_hand + paper_page(answers);
  if (std::getenv("ABERFIT_WRITE_PAGES")) std::ofstream(kFolder + "README.md") << now;
  EXPECT_EQ(read_file(kFolder + "README.md"), now) << "the page says how it is written anew";
}

TEST_F(PaperAudit, BranchesAreEquivalentByRaysAndInLight) {
  EXPECT_EQ(report_->verdict, Verdict::kEquivalent);
  EXPECT_TRUE(report_->rays_decide);  // the study names the geometric theory
  EXPECT_EQ(report_->light_verdict, Verdict::kEquivalent);
  EXPECT_GT(report_->draws, 100);
  const auto result = to_json(*report_, resolved_study(*study_));
  EXPECT_EQ(result["headline"], "EQUIVALENT by geometric rays; by wave optics EQUIVALENT");
  EXPECT_EQ(result["decided_by"], "rays");
  EXPECT_EQ(text_of(page_of(*report_)).find("EQUIVALENT by geometric rays; by wave optics EQUIVALENT\n"), 0u);
  auto written = nlohmann::ordered_json::parse(read_file(folder_->file("out/result.json")));
  written["provenance"] = result["provenance"];
  EXPECT_EQ(written, result);
  EXPECT_EQ(read_file(folder_->file("out/summary.txt")), text_of(page_of(*report_)));
  // The closed theory agrees with its own rays, and generalised Harvey-Shack with waves, within 4.5 standard
  // errors.
  for (std::size_t k = 0; k < report_->metrics.size(); ++k) {
    const EquivalenceMetric& m = report_->metrics[k];
    EXPECT_NEAR(m.target / report_->theory[k], 1, 4.5 * m.standard_error) << m.name;
    EXPECT_NEAR(m.difference, 0, 4.5 * m.standard_error) << m.name;
    EXPECT_LT(m.standard_error, 0.004) << m.name;  // what makes a margin of 1 % decidable
  }
  // Intervals of means of 16 groups, one-sided 95 % of Student's t: 1.7531 with 15 degrees of freedom by wave
  // optics, where the theory has no error; 1.6973 with 30 for two independent errors of the same size.
  const auto quantile = [](const EquivalenceMetric& m) {
    return (m.interval[1] - m.interval[0]) / 2 / m.standard_error;
  };
  for (const EquivalenceMetric& m : report_->light) EXPECT_NEAR(quantile(m), 1.753050356, 1e-6) << m.name;
  for (const EquivalenceMetric& m : report_->metrics) {
    EXPECT_GT(quantile(m), 1.697260) << m.name;
    EXPECT_LT(quantile(m), 1.753051) << m.name;
  }
  ASSERT_GE(report_->light.size(), 8u);
  for (const EquivalenceMetric& m : report_->light) {
    EXPECT_NEAR(m.difference, 0, 4.5 * m.standard_error) << m.name;
    EXPECT_LT(m.standard_error, 0.005) << m.name;
  }
  // Ensemble means against the closed forms of PHYSICS 5.
  EXPECT_NEAR(paper_->hs("ee90_radius_m") / 75.55e-6, 1, 0.002);
  EXPECT_NEAR(paper_->hs("ring_fwhm_m") / 2.967e-3, 1, 0.002);
  EXPECT_NEAR(paper_->hs("scatter_mean_rad") / 1.574e-5, 1, 0.002);
}

TEST_F(PaperAudit, EveryFigureThatIsAPictureIsDrawn) {
  for (const std::string& name : verify_picture_names())
    EXPECT_TRUE(std::filesystem::exists(folder_->file("out/plots/" + name + ".gp"))) << name;
  // Not drawn are the bare mirror, points on it, the cloud of both gradients, and the modes of the sum.
  const std::set<std::string> undrawn = {"fig-1a", "fig-1b", "fig-2a", "fig-2b", "fig-6",
                                         "fig-8a", "fig-8b", "fig-8c", "fig-8d"};
  std::set<std::string> named;
  for (const PaperNumber& row : paper_->numbers) {
    named.insert(row.picture);
    EXPECT_EQ(row.kind == "figure" && row.picture.empty(), undrawn.contains(row.id)) << row.id;
  }
  named.erase("");
  EXPECT_EQ(named.size(), verify_picture_names().size()) << "a picture that answers nothing";
  bool drawn = true;
  for (const Warning& warning : report_->warnings) drawn = drawn && warning.code != "no-gnuplot";
  if (!drawn) GTEST_SKIP() << "no gnuplot here";
  for (const std::string& name : named)
    EXPECT_TRUE(std::filesystem::exists(folder_->file("out/plots/" + name + ".svg")) ||
                std::filesystem::exists(folder_->file("out/plots/" + name + ".png")))
        << name;
}

namespace {
class PaperListOnRealData : public RealData {
 protected:
  PaperListOnRealData() : RealData("paper") {}
};
}  // namespace

// The list equals, number by number, the data that was compiled from the paper.
TEST_F(PaperListOnRealData, IsTheCompiledOne) {
  std::map<std::string, PaperNumber> ours;
  for (const PaperNumber& row : paper_numbers()) ours[row.id] = row;
  std::ifstream numbers(file("numbers.csv"));
  std::string line;
  std::getline(numbers, line);
  int count = 0;
  for (; std::getline(numbers, line); ++count) {
    const std::vector<std::string> cells = csv_cells(line);
    ASSERT_TRUE(ours.contains(cells.at(0))) << line;
    const PaperNumber& row = ours[cells[0]];
    EXPECT_EQ(row.section, cells[1]);
    EXPECT_EQ(row.kind, cells[2]);
    EXPECT_EQ(row.label, cells[3]);
    EXPECT_EQ(row.printed, cells[4]);
    std::string verdict = cells.at(7).substr(0, cells[7].find_first_of(" .,:;"));
    for (char& c : verdict) c = char(std::tolower(static_cast<unsigned char>(c)));
    EXPECT_EQ(row.verdict, verdict) << row.id;
  }
  EXPECT_EQ(count, 195);
}
