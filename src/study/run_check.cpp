#include <fmt/format.h>

#include <filesystem>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/units.h"
#include "aberfit/scene/characterisation.h"
#include "aberfit/study/read_study.h"
#include "aberfit/study/run.h"
#include "cost_model.h"
#include "run_map_fit.h"
#include "scene.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;

// The chart's rates where one is given, else those that came with the program.
FitRates rates_for(const Study& study, const RunOptions& options) {
  const bool there = !options.chart_file.empty() && std::filesystem::exists(options.chart_file);
  if (options.chart_file.empty() || (options.chart_optional && !there)) return built_in_rates();
  bool same_study = false;
  try {
    const FitRates rates = read_rates(options.chart_file, resolved_study(study), &same_study);
    return options.chart_optional && !same_study ? built_in_rates() : rates;
  } catch (const InputError&) {
    if (!options.chart_optional) throw;  // nobody asked for this one
    return built_in_rates();
  }
}

std::string seconds_text(double seconds) {
  if (seconds < 99.5) return fmt::format("{:.2g} s", seconds);
  return seconds < 5970 ? fmt::format("{:.2g} min", seconds / 60) : fmt::format("{:.0f} h", seconds / 3600);
}

// A study of a measured map has no specification: what is fitted, and where it comes from.
ordered_json check_map_study(const Study& study, int threads, std::string* table) {
  const HeightMap map = load_map(study);
  const TermSet terms = map_terms(study, aperture_radius(study.aperture));
  std::string text = study.title.empty() ? "" : study.title + "\n\n";
  text += fmt::format("  {:<34} {} x {} points, {} valid, pitch {}\n", "map", map.columns(), map.rows(),
                      valid_count(map), format_quantity(map.pitch_x, Dimension::kLength));
  text += fmt::format("  {:<34} {} by least squares\n", "terms", terms.size());
  const double seconds = predict_map_fit(double(valid_count(map)), double(terms.size()), threads);
  text += fmt::format("  {:<34} {} on {} thread{} (within a factor 3)\n", "predicted time of `fit`",
                      seconds_text(seconds), threads, threads == 1 ? "" : "s");
  if (table) *table = text;
  return {{"aberfit", 1},
          {"kind", "check"},
          {"study", resolved_study(study)},
          {"map",
           {{"columns", map.columns()},
            {"rows", map.rows()},
            {"valid", valid_count(map)},
            {"pitch_m", map.pitch_x}}},
          {"terms", {{"count", terms.size()}}},
          {"predicted_seconds", seconds},
          {"warnings", ordered_json::array()}};
}

}  // namespace

ordered_json run_check(const Study& study, const RunOptions& options, std::string* table) {
  const int threads = options.threads > 0 ? options.threads : available_threads();
  if (study.target.map) return check_map_study(study, threads, table);
  const Scene scene = make_scene(study);
  double captured = 0;
  const TermSet terms = make_terms(study, scene, &captured);
  const TargetSets targets = make_targets(study, scene, threads);
  const Warnings warnings = scene_warnings(study, scene, terms, captured);
  ordered_json result = {{"aberfit", 1}, {"kind", "check"}, {"study", resolved_study(study)}};
  std::string text = study.title.empty() ? "" : study.title + "\n\n";
  const auto row = [&](const std::string& label, const std::string& value) {
    text += fmt::format("  {:<34} {}\n", label, value);
  };
  const MirrorCharacterisation rim = characterise(study.mirror, study.aperture);
  row("f-number", fmt::format("f/{:.3g}", rim.f_number));
  row("rim above vertex", format_quantity(rim.rim_sag_max, Dimension::kLength));
  result["mirror"] = {{"f_number", rim.f_number},
                      {"rim_sag_m", rim.rim_sag_max},
                      {"rim_plane_residual_m", rim.plane_residual}};
  if (scene.psd) {
    const SceneNumbers& n = scene.numbers;
    row("RMS height", format_quantity(n.rms_height, Dimension::kLength));
    row("RMS slope per axis", format_quantity(n.rms_slope_per_axis, Dimension::kAngle));
    row("spot scale sigma_f", format_quantity(scene.focal_sigma, Dimension::kLength));
    row("slope-carrying modes N_eff",
        fmt::format("{:.0f}: ee90 of draws spreads by {:.1f} %", n.n_eff, 100 * n.realisation_spread));
    row("g = 4 pi sigma/lambda", fmt::format("{:.3g}, TIS {:.3g}", n.g, n.tis));
    row("kappa (rays from 0.85 up)", fmt::format("{:.3g}", n.kappa));
    row("R of the paper (decides nothing)", fmt::format("{:.4g}", n.paper_ratio_r));
    row("model", n.reason);
    result["scene"] = {{"rms_height_m", n.rms_height},
                       {"rms_slope_per_axis", n.rms_slope_per_axis},
                       {"n_eff", n.n_eff},
                       {"g", n.g},
                       {"kappa", n.kappa},
                       {"tis", n.tis},
                       {"paper_ratio_r", n.paper_ratio_r},
                       {"focal_sigma_m", scene.focal_sigma},
                       {"rays_are_valid", n.rays_are_valid},
                       {"reason", n.reason}};
  }
  row("terms", fmt::format("{} ({:.2f} % of the height variance)", terms.size(), 100 * captured));
  row("statistics", fmt::format("{} fitted, {} guides, {} held out; targets: {}", targets.fitted.size(),
                                targets.guides.size(), targets.held_out.size(), targets.theory));
  row("rays", fmt::format("{}", study.trace.pupil.rays));
  const FitRates rates = rates_for(study, options);
  const auto stages = predict_fit(rates, fit_size(study, terms, targets, threads));
  double seconds = 0;
  for (const auto& [stage, cost] : stages) seconds += cost;
  row("predicted time of `fit`",
      fmt::format("{} on {} thread{}, pictures left out (rates {})", seconds_text(seconds), threads,
                  threads == 1 ? "" : "s", rates.source));
  ordered_json costs;
  for (const auto& [stage, cost] : stages) {
    const bool iterations = stage == "iterations";
    row("  " + stage,
        seconds_text(cost) +
            (!iterations
                 ? ""
                 : fmt::format(" for {:.0f}{}{}", rates.iterations,
                               rates.iterations_known ? "" : ", a typical number",
                               study.fit.starts > 1
                                   ? fmt::format("; as much for each further of {} starts", study.fit.starts)
                                   : "")));
    costs[stage] = cost;
  }
  result["terms"] = {{"count", terms.size()}, {"captured_fraction", captured}};
  result["predicted_seconds"] = seconds;
  result["prediction"] = {{"rates", rates.source},
                          {"iterations", rates.iterations},
                          {"iterations_known", rates.iterations_known},
                          {"stages_seconds", costs}};
  result["warnings"] = ordered_json::array();
  for (const Warning& warning : warnings) {
    result["warnings"].push_back({{"code", warning.code}, {"message", warning.message}});
    text += fmt::format("\n  {}: {}\n", warning.code, warning.message);
  }
  if (table) *table = text;
  return result;
}

}  // namespace aberfit
