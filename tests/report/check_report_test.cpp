// A hand-made report of `check`: the table and the JSON show the same numbers.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "aberfit/report/documents.h"
#include "report/hand_made_scene.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;

CheckReport hand_made() {
  CheckReport report;
  report.title = "by hand";
  report.mirror.f_number = 7;
  report.mirror.rim_sag_max = 3.5e-3;
  report.mirror.plane_residual = 0;
  report.scene = test::scene_of_waves();
  report.scene->mean_light = {
      "ghs", 2, {{"ee80_diameter", 30e-6, true}, {"hew", 6e-6, true}, {"strehl", 0.81, false}}, {}};
  report.focal_sigma = 8e-6;
  report.theory = "geometric";
  report.reason = report.scene->reason;
  report.too_simple = true;
  report.terms = {228, 0.985};
  report.statistics = {9, 2, 5};
  report.rays = 65536;
  report.threads = 2;
  report.cost = CheckedCost{65536, 11, 2.5e8, 0.25, false, 1.5, ""};
  report.warnings = {{"some-code", "A sentence."}};
  return report;
}

// Value of the row with this label, its lines joined; empty where there is none.
std::string row(const std::string& table, const std::string& label) {
  const std::size_t at = table.find("\n  " + label + "  ");
  if (at == std::string::npos) return "";
  std::size_t from = table.find_first_not_of(' ', at + 3 + label.size()), end = table.find('\n', from);
  const std::string further = "\n" + std::string(from - at - 1, ' ');
  std::string value = table.substr(from, end - from);
  while (table.compare(end, further.size(), further) == 0) {
    from = end + further.size(), end = table.find('\n', from);
    value += " " + table.substr(from, end - from);
  }
  return value;
}

TEST(CheckReport, TableAndJsonSayTheSame) {
  const CheckReport report = hand_made();
  const std::string table = text_of(page_of(report));
  std::istringstream lines(table);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  const ordered_json json = to_json(report, {{"title", "by hand"}});
  EXPECT_EQ(table.find("Study     by hand\n"), 0u) << table;
  EXPECT_EQ(json["kind"], "check");
  EXPECT_EQ(json["study"]["title"], "by hand");
  EXPECT_EQ(row(table, "f-number"), "f/7");
  EXPECT_EQ(json["mirror"]["f_number"], 7);
  EXPECT_EQ(row(table, "spot scale sigma_f"), "8 um");
  EXPECT_EQ(json["scene"]["focal_sigma_m"], 8e-6);
  EXPECT_EQ(row(table, "ee90 by rays"), "18 um, wrong by -10 %; ee50 by +250 %");
  EXPECT_EQ(json["scene"]["rays_ee90_radius_m"], 18e-6);
  EXPECT_EQ(json["scene"]["model_error"]["ray_ee90"], -0.1);
  EXPECT_EQ(row(table, "ee90 by Harvey-Shack (waves)"), "20 um, ee50 3 um, ee80 15 um");
  EXPECT_EQ(json["scene"]["ghs"]["ee90_radius_m"], 20e-6);
  EXPECT_EQ(row(table, "mean PSF, diameters"), "ee80 30 um");
  EXPECT_EQ(row(table, "  on the sky [arcsec]"), "ee80 3.09") << "15 urad";
  EXPECT_EQ(row(table, "  its ratios"), "strehl 0.81");
  EXPECT_EQ(json["scene"]["mean_light"], (ordered_json{{"theory", "ghs"},
                                                       {"ee80_diameter_m", 30e-6},
                                                       {"ee80_diameter_rad", 15e-6},
                                                       {"hew_m", 6e-6},
                                                       {"hew_rad", 3e-6},
                                                       {"strehl", 0.81}}));
  EXPECT_EQ(row(table, "model needed"), "waves");
  EXPECT_EQ(json["scene"]["needed"], "waves");
  EXPECT_EQ(row(table, "models used"),
            "targets geometric, surface rays simpler than needed; `fit` will judge by waves");
  EXPECT_EQ(json["scene"]["theory"], "geometric");
  EXPECT_EQ(json["scene"]["model"], "rays");
  EXPECT_NE(table.find("simpler than needed; `fit` will judge by waves"), std::string::npos);
  CheckReport named = report;  // named by the study
  named.light_decides = false;
  const std::string of_named = text_of(page_of(named));
  EXPECT_EQ(of_named.find("will judge by waves"), std::string::npos);
  EXPECT_NE(row(of_named, "models used")
                .find("will judge by theory `geometric` and report the result of wave optics"),
            std::string::npos);
  EXPECT_EQ(row(table, "terms"), "228 (98.50 % of the height variance)");
  EXPECT_EQ(
      json["terms"],
      (ordered_json{{"count", 228}, {"captured_fraction", 0.985}, {"automatic", false}, {"n_max", nullptr}}));
  EXPECT_EQ(row(table, "statistics"), "9 fitted, 2 guides, 5 held out; targets: geometric");
  CheckReport through = report;
  through.held_out.push_back({EncircledEnergyRadius{0.5, -2e-3}, 1e-4});
  EXPECT_NE(row(text_of(page_of(through)), "statistics").find(", in planes up to 2 mm from the focus; "),
            std::string::npos);
  through.fitted = {{RingFwhm{}, 6e-3}};  // to half of its width
  EXPECT_NE(row(text_of(page_of(through)), "statistics").find(", in planes up to 3 mm from the focus; "),
            std::string::npos);
  through.held_out.clear();
  through.fitted = {{RmsHeight{}, 2e-8}};
  EXPECT_EQ(row(text_of(page_of(through)), "statistics"),
            "9 fitted, 2 guides, 5 held out; targets: geometric");
  EXPECT_EQ(row(table, "rays"), "65536");
  EXPECT_EQ(row(table, "memory of `fit`"), "250 MB: 11 residuals on 65536 rays");
  EXPECT_EQ(row(table, "one iteration"), "0.25 s on 2 threads, just measured");
  EXPECT_EQ(row(table, "time of `fit`"),
            "10 to 40 iterations: 2.5 s to 10 s, and 1.5 s for the verdict; realisations to compare with and "
            "pictures come on top");
  EXPECT_EQ(json["cost"], (ordered_json{{"pupil_points", 65536},
                                        {"residuals", 11},
                                        {"bytes", 2.5e8},
                                        {"threads", 2},
                                        {"iteration_seconds", 0.25},
                                        {"at_least", false},
                                        {"iterations", {10, 40}},
                                        {"iterations_seconds", {2.5, 10.0}},
                                        {"verdict_seconds", 1.5},
                                        {"obstacle", nullptr}}));
  EXPECT_NE(table.find("[some-code] A sentence.\n"), std::string::npos) << table;
  EXPECT_EQ(json["warnings"][0]["code"], "some-code");
}

TEST(CheckReport, ListsEveryTargetOfTheVerdictAsAResultDoes) {
  CheckReport report = hand_made();
  Target fitted, held_out;
  fitted.statistic = EncircledEnergyRadius{0.9, 0};
  fitted.value = 8e-5;
  fitted.tolerance = 8e-8;
  fitted.standard_error = 1e-9;
  held_out.statistic = EncircledEnergyRadius{0.25, 1e-3};
  held_out.value = 3e-5;
  report.fitted = {fitted};
  report.held_out = {held_out};
  const ordered_json json = to_json(report, {})["target"];
  EXPECT_EQ(
      json["ee90_radius_m"],
      (ordered_json{{"value", 8e-5}, {"standard_error", 1e-9}, {"tolerance", 8e-8}, {"held_out", false}}));
  EXPECT_EQ(json["ee25_radius_m@1mm"]["value"], 3e-5);
  EXPECT_EQ(json["ee25_radius_m@1mm"]["held_out"], true);
}

TEST(CheckReport, SaysWhatTheWaveTheoryLeavesOutAndHowManyCellsThereAre) {
  CheckReport report = hand_made();
  EXPECT_EQ(row(text_of(page_of(report)), "error of the wave theory"), "");
  EXPECT_FALSE(to_json(report, {}).contains("theory_error"));
  EXPECT_FALSE(to_json(report, {}).contains("cells_across"));
  TheoryError error;
  error.paraxial = 6.4e-4;
  error.small_angle = 2e-5;
  error.beyond_ten_degrees = 3e-6;
  report.theory_error = error;
  report.model = FocusModel::kWaves;
  EXPECT_EQ(row(text_of(page_of(report)), "rays"), "none: wave optics, but no grid is fine enough");
  report.cells = CheckedCells{136.4, 386};
  const std::string table = text_of(page_of(report));
  EXPECT_EQ(
      row(table, "error of the wave theory"),
      "radii: 0.002 % from the small-angle approximation; 0.0003 % of the energy goes beyond 10 degrees");
  CheckReport narrow = report;
  narrow.theory_error->beyond_ten_degrees = 1.7e-11;
  EXPECT_EQ(row(text_of(page_of(narrow)), "error of the wave theory"),
            "radii: 0.002 % from the small-angle approximation; less than 0.0001 % of the energy goes beyond "
            "10 degrees");
  EXPECT_EQ(row(table, "rays"), "none: wave optics on a grid of 136 points across, judged on 386");
  const ordered_json json = to_json(report, {});
  EXPECT_EQ(json["theory_error"]["small_angle"], 2e-5);
  EXPECT_EQ(json["theory_error"]["beyond_ten_degrees"], 3e-6);
  EXPECT_EQ(json["theory_error"]["paraxial"], 6.4e-4);
  EXPECT_EQ(json["cells_across"], (ordered_json{{"fit", 136.4}, {"verdict", 386}}));
  report.theory_error->small_angle = HUGE_VAL;
  EXPECT_NE(text_of(page_of(report)).find("radii: an unknown fraction from the small-angle approximation"),
            std::string::npos);
  EXPECT_TRUE(to_json(report, {})["theory_error"]["small_angle"].is_null());
}

TEST(CheckReport, AutomaticTermsAreThoseThatAFitBeginsWith) {
  CheckReport report = hand_made();
  report.terms = {1650, 0.9993, true, 57};
  report.automatic_rays = true;
  const std::string table = text_of(page_of(report));
  EXPECT_EQ(row(table, "terms"), "1650, Zernikes to n = 57 at first (99.93 % of the height variance)");
  EXPECT_EQ(row(table, "rays"), "the fit chooses: at least 65536 for so many terms");
  EXPECT_EQ(
      to_json(report, {})["terms"],
      (ordered_json{{"count", 1650}, {"captured_fraction", 0.9993}, {"automatic", true}, {"n_max", 57}}));
}

TEST(CheckReport, AnIterationThatWasNotMadeOrNotWaitedForSaysSo) {
  CheckReport report = hand_made();
  report.model = FocusModel::kWaves;
  report.scene.reset();
  report.cost->iteration_seconds = 120;
  report.cost->at_least = true;
  report.cost->verdict_seconds.reset();
  EXPECT_EQ(row(text_of(page_of(report)), "one iteration"), "more than 2 min on 2 threads, just measured");
  EXPECT_EQ(row(text_of(page_of(report)), "time of `fit`"),
            "10 to 40 iterations: more than 20 min to 80 min; realisations to compare with and pictures come "
            "on top");
  EXPECT_EQ(to_json(report, {})["cost"]["at_least"], true);
  report.cost->iteration_seconds.reset();
  report.cost->obstacle = "the grid is too fine";
  report.cost->bytes = 4e12;
  const std::string table = text_of(page_of(report));
  EXPECT_EQ(row(table, "memory of `fit`"), "4000.0 GB: 11 residuals on 65536 grid points");
  EXPECT_EQ(row(table, "time of `fit`"), "not measured: the grid is too fine");
  EXPECT_EQ(row(table, "models"), "targets geometric, surface waves: kappa is too small.");
  const ordered_json json = to_json(report, {});
  EXPECT_TRUE(json["cost"]["iteration_seconds"].is_null());
  EXPECT_TRUE(json["cost"]["iterations_seconds"][1].is_null());
  EXPECT_EQ(json["cost"]["obstacle"], "the grid is too fine");
  EXPECT_FALSE(json.contains("scene"));
  report.cost.reset();
  EXPECT_FALSE(to_json(report, {}).contains("cost"));
}

TEST(MapCheckReport, SaysWhatIsFitted) {
  MapCheckReport report;
  report.title = "a map";
  report.columns = 64;
  report.rows = 32;
  report.valid = 1500;
  report.pitch_x = 1e-4;
  report.pitch_y = 5e-5;
  report.terms = 25;
  const std::string table = text_of(page_of(report));
  EXPECT_EQ(table.find("Study     a map\n"), 0u);
  EXPECT_EQ(row(table, "map"), "64 x 32 points, 1500 valid, pitch 100 um along x, 50 um along y");
  EXPECT_EQ(row(table, "terms"), "25 by least squares");
  const ordered_json json = to_json(report, {});
  EXPECT_EQ(json["map"], (ordered_json{{"columns", 64},
                                       {"rows", 32},
                                       {"valid", 1500},
                                       {"pitch_m", nullptr},
                                       {"pitch_x_m", 1e-4},
                                       {"pitch_y_m", 5e-5}}));
  report.pitch_y = report.pitch_x;
  EXPECT_EQ(row(text_of(page_of(report)), "map"), "64 x 32 points, 1500 valid, pitch 100 um along x and y");
  EXPECT_EQ(to_json(report, {})["map"]["pitch_m"], 1e-4);
  EXPECT_EQ(json["terms"]["count"], 25);
}

}  // namespace
}  // namespace aberfit
