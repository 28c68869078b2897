#include "aberfit/report/check_report.h"

#include <fmt/format.h>

#include "aberfit/method/constants.h"
#include "aberfit/report/band_shares.h"
#include "json_number.h"
#include "paper_table.h"
#include "scene_facts_json.h"
#include "statistic_label.h"
#include "target_json.h"

namespace aberfit {
using namespace internal;

namespace {

Json checked_scene_json(const CheckReport& report) {
  Json json = scene_json(*report.scene);
  const ModelErrors& e = *report.scene->errors;
  json["rays_ee90_radius_m"] = e.rays.ee90;
  json["focal_sigma_m"] = report.focal_sigma;
  json["paper_verdict"] = paper_verdict(report.scene->numbers.paper_ratio_r);
  return json;
}

Json checked_terms_json(const CheckedTerms& terms) {
  Json json = {{"count", terms.count}, {"captured_fraction", terms.captured}};
  json["automatic"] = terms.automatic;
  json["n_max"] = terms.order > 0 ? Json(terms.order) : Json(nullptr);
  if (terms.segments > 0) json["segments"] = terms.segments;
  return json;
}

Json theory_error_json(const TheoryError& error) {
  return {{"paraxial", error.paraxial},
          {"small_angle", json_number(error.small_angle)},
          {"beyond_ten_degrees", error.beyond_ten_degrees},
          {"cut_share", error.cut_share}};
}

Json targets_json(const CheckReport& report) {
  std::vector<Target> all = report.fitted;
  all.insert(all.end(), report.held_out.begin(), report.held_out.end());
  const std::vector<std::string> names = unique_names(all);
  Json json = Json::object();
  for (std::size_t k = 0; k < all.size(); ++k) {
    json[names[k]] = target_json(all[k]);
    json[names[k]]["held_out"] = k >= report.fitted.size();
  }
  return json;
}

Json cost_json(const CheckedCost& cost, int threads) {
  const auto seconds = [&](int iterations) {
    return cost.iteration_seconds ? Json(iterations * *cost.iteration_seconds) : Json(nullptr);
  };
  return {{"pupil_points", cost.points},
          {"residuals", cost.residuals},
          {"bytes", cost.bytes},
          {"threads", threads},
          {"iteration_seconds", seconds(1)},
          {"at_least", cost.at_least},
          {"iterations", {law::kFewIterations, law::kManyIterations}},
          {"iterations_seconds", {seconds(law::kFewIterations), seconds(law::kManyIterations)}},
          {"verdict_seconds", cost.verdict_seconds ? Json(*cost.verdict_seconds) : Json(nullptr)},
          {"obstacle", cost.obstacle.empty() ? Json(nullptr) : Json(cost.obstacle)}};
}

}  // namespace

Json to_json(const CheckReport& report, const Json& study) {
  Json json = json_document("check", study);
  json["mirror"] = {{"f_number", report.mirror.f_number},
                    {"rim_sag_m", report.mirror.rim_sag_max},
                    {"rim_plane_residual_m", report.mirror.plane_residual}};
  if (report.scene) json["scene"] = checked_scene_json(report);
  if (report.theory_error) json["theory_error"] = theory_error_json(*report.theory_error);
  json["target"] = targets_json(report);
  if (report.cells) json["cells_across"] = {{"fit", report.cells->fit}, {"verdict", report.cells->verdict}};
  json["terms"] = checked_terms_json(report.terms);
  if (report.shares) json["split"] = to_json(*report.shares, std::nullopt, std::nullopt);
  if (report.cost) json["cost"] = cost_json(*report.cost, report.threads);
  json["warnings"] = json_warnings(report.warnings);
  if (report.paper_table) json["paper_table"] = to_json(*report.paper_table);
  return json;
}

Json to_json(const MapCheckReport& report, const Json& study) {
  Json json = json_document("check", study);
  json["map"] = {{"columns", report.columns},
                 {"rows", report.rows},
                 {"valid", report.valid},
                 {"pitch_m", report.pitch_x == report.pitch_y ? Json(report.pitch_x) : Json()},
                 {"pitch_x_m", report.pitch_x},
                 {"pitch_y_m", report.pitch_y}};
  json["terms"]["count"] = report.terms;
  if (report.shares) json["split"] = to_json(*report.shares, std::nullopt, std::nullopt);
  json["warnings"] = json_warnings(report.warnings);
  return json;
}

}  // namespace aberfit
