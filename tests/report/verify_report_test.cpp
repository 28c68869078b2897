// Hand-made reports of `verify` and `trace`: the table and the JSON show the same numbers.
#include "aberfit/report/verify_report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "aberfit/report/documents.h"
#include "report/hand_made_scene.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;

EquivalenceMetric metric(const std::string& name, double target, double model, Verdict verdict) {
  EquivalenceMetric m;
  m.name = name;
  m.target = target;
  m.model = model;
  m.relative_difference = m.difference = model / target - 1;
  m.interval[0] = m.relative_difference - 0.01;
  m.interval[1] = m.relative_difference + 0.01;
  m.verdict = verdict;
  return m;
}

VerifyReport hand_made() {
  VerifyReport report;
  report.title = "by hand";
  report.convention = Convention::kPaper;
  report.verdict = report.rays_verdict = Verdict::kDifferent;
  report.rays_decide = true;
  report.scene = test::scene_of_waves();
  report.rays = 15000;
  report.draws = 576;
  report.margin = 0.05;
  report.theory = {75e-6, NAN};
  report.metrics = {metric("ee90_radius_m", 80e-6, 82e-6, Verdict::kEquivalent),
                    metric("ring_fwhm_m", 2e-3, 3e-3, Verdict::kDifferent)};
  report.light = {metric("ee90_radius_m", 70e-6, 71e-6, Verdict::kEquivalent)};
  report.light_verdict = Verdict::kEquivalent;
  report.light_draws = 320;
  report.warnings = {{"some-code", "A sentence."}};
  return report;
}

// The line of `table` that begins with two blanks and `label`.
std::string line_of(const std::string& table, const std::string& label) {
  const std::size_t at = table.find("\n  " + label + " ");
  return at == std::string::npos ? "" : table.substr(at + 3, table.find('\n', at + 1) - at - 3);
}

TEST(VerifyReport, HeadlineTableAndJsonSayTheSame) {
  const VerifyReport report = hand_made();
  const std::string table = text_of(page_of(report));
  const ordered_json json = to_json(report, {{"title", "by hand"}});
  EXPECT_EQ(table.find("DIFFERENT (ring_fwhm +50.00 %) by geometric rays; by wave optics EQUIVALENT\n---"),
            0u)
      << table;
  EXPECT_NE(table.find("Study     by hand\nJudged    the mean PSF of 576 random surfaces, at a margin of 5 "
                       "%, convention paper\n"),
            std::string::npos)
      << table;
  EXPECT_EQ(json["headline"], "DIFFERENT (ring_fwhm +50.00 %) by geometric rays; by wave optics EQUIVALENT");
  EXPECT_EQ(json["decided_by"], "rays");
  EXPECT_EQ(json["draws"], 576);
  EXPECT_EQ(json["light"]["draws"], 320);
  EXPECT_EQ(json["light"]["verdict"], "equivalent");
  EXPECT_EQ(json["light"]["statistics"]["ee90_radius_m"]["ghs"], 70e-6);
  EXPECT_EQ(json["light"]["statistics"]["ee90_radius_m"]["waves"], 71e-6);
  const std::string in_light = table.substr(table.find("By wave optics:"));
  for (const char* cell : {"70.00 um", "71.00 um", "+1.43", "equivalent"})
    EXPECT_NE(line_of(in_light, "ee90_radius").find(cell), std::string::npos) << cell << "\n" << table;
  EXPECT_EQ(json["kind"], "verify");
  EXPECT_EQ(json["study"]["title"], "by hand");
  EXPECT_EQ(json["convention"], "paper");
  EXPECT_EQ(json["verdict"], "different");
  EXPECT_EQ(json["scene"]["needed"], "waves");
  for (const char* cell : {"75.00 um", "80.00 um", "82.00 um", "+2.50", "equivalent"})
    EXPECT_NE(line_of(table, "ee90_radius").find(cell), std::string::npos) << cell << "\n" << table;
  const ordered_json& ee90 = json["statistics"]["ee90_radius_m"];
  EXPECT_EQ(ee90["theory"], 75e-6);
  EXPECT_EQ(ee90["harvey_shack"], 80e-6);
  EXPECT_EQ(ee90["aberration_terms"], 82e-6);
  EXPECT_EQ(ee90["verdict"], "equivalent");
  EXPECT_EQ(ee90["interval"].size(), 2u);
  EXPECT_NE(line_of(table, "ring_fwhm").find("DIFFERENT"), std::string::npos);
  EXPECT_TRUE(json["statistics"]["ring_fwhm_m"]["theory"].is_null());
  EXPECT_EQ(json["warnings"][0]["message"], "A sentence.");
  EXPECT_NE(table.find("[some-code] A sentence.\n"), std::string::npos);
}

TEST(VerifyReport, LightThatDecidesStandsFirst) {
  VerifyReport report = hand_made();
  report.rays_decide = false;
  report.verdict = report.light_verdict;
  EXPECT_EQ(to_json(report, {})["headline"],
            "EQUIVALENT by wave optics; by geometric rays DIFFERENT (ring_fwhm +50.00 %)");
  report.draws = 0;
  report.light.clear();
  report.light_obstacle = "a polygon";
  report.rays_decide = true;
  const std::string table = text_of(page_of(report));
  EXPECT_NE(table.find("; by wave optics not computed\n"), std::string::npos) << table;
  EXPECT_NE(table.find("Judged    the given surface by 15000 rays, at a margin of 5 %"), std::string::npos)
      << table;
  EXPECT_EQ(to_json(report, {})["light"]["obstacle"], "a polygon");
}

TEST(TraceReport, TableAndJsonSayTheSame) {
  TraceReport report;
  report.title = "by hand";
  report.theory = "ghs";
  report.model = FocusModel::kWaves;
  report.reason = "kappa is too small.";
  report.rays = 4096;
  report.lost_rays = 0;
  report.terms = 42;
  report.statistics = {{EncircledEnergyRadius{0.9, 0}, 66e-6, 60e-6}, {ScatterRms{}, NAN, 3e-5}};
  const std::string table = text_of(page_of(report));
  const ordered_json json = to_json(report, {});
  EXPECT_EQ(
      table.find("The surface is within 10 % of its targets in 1 statistic (ee90_radius is farthest)\n"), 0u);
  EXPECT_EQ(json["headline"], table.substr(0, table.find('\n')));
  EXPECT_NE(table.find("Study     by hand\nModel     waves, 4096 grid points (0 lost), 42 terms\n"),
            std::string::npos);
  EXPECT_EQ(json["kind"], "trace");
  EXPECT_EQ(json["model"], "waves");
  EXPECT_EQ(json["theory"], "ghs");
  EXPECT_EQ(json["pupil_points"], 4096);
  EXPECT_EQ(json["terms"], 42);
  for (const char* cell : {"66.00 um", "60.00 um", "+10.000"})
    EXPECT_NE(line_of(table, "ee90_radius").find(cell), std::string::npos) << cell << "\n" << table;
  EXPECT_EQ(json["statistics"]["ee90_radius_m"], 66e-6);
  EXPECT_EQ(json["target"]["ee90_radius_m"], 60e-6);
  EXPECT_TRUE(json["statistics"]["scatter_rms_rad"].is_null());
  report.model = FocusModel::kRays;
  EXPECT_NE(text_of(page_of(report)).find("4096 rays"), std::string::npos);
}

}  // namespace
}  // namespace aberfit
