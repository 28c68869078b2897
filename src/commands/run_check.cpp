#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/units.h"
#include "aberfit/scene/characterisation.h"
#include "aberfit/study/read_study.h"
#include "aberfit/commands/run.h"
#include "aberfit/chart/cost_model.h"
#include "aberfit/method/judge.h"
#include "paper_table.h"
#include "aberfit/method/ray_count.h"
#include "run_map_fit.h"
#include "aberfit/method/scene.h"
#include "aberfit/method/term_search.h"

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

// No more digits than a prediction has: "20 s", "15 s", "2 min".
std::string rounded_text(double seconds) {
  if (seconds < 0.1) return "less than 0.1 s";
  const double unit = seconds < 99.5 ? 1 : seconds < 5970 ? 60 : 3600;
  const double amount = seconds / unit;
  const double digit = std::pow(10, std::floor(std::log10(amount)));
  const double step = amount < 2 * digit ? 0.5 * digit : digit;  // one digit, and halves below two
  return fmt::format("about {:.3g} {}", step * std::round(amount / step),
                     unit == 1    ? "s"
                     : unit == 60 ? "min"
                                  : "h");
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

// R, kappa and GHS of the specification, with both verdicts side by side. `row` prints a label and a value.
template <typename Row>
ordered_json check_scene(const Study& study, const Scene& scene, const std::string& theory, const Row& row) {
  const SceneNumbers& n = scene.numbers;
  ResultDocument facts;  // the same numbers under the same keys as in a result
  facts.has_roughness = true;
  facts.scene = n;
  describe_models(scene, theory, &facts);
  facts.realisation = Realisation{n.realisation_spread, std::nan(""), 0};
  ordered_json json = scene_json(facts);
  const ModelErrors& e = *facts.errors;
  row("g = 4 pi sigma/lambda", fmt::format("{:.3g}, TIS {:.3g}", n.g, n.tis));
  row("kappa (rays from 0.85 up)", fmt::format("{:.3g}", n.kappa));
  row("Airy ee90", format_quantity(n.airy_ee90, Dimension::kLength));
  row("ee90 by Harvey-Shack (waves)",
      format_quantity(e.ghs.ee90, Dimension::kLength) +
          fmt::format(", ee50 {}, ee80 {}", format_quantity(e.ghs.ee50, Dimension::kLength),
                      format_quantity(e.ghs.ee80, Dimension::kLength)));
  const auto error = [&](const char* label, const ModelRadii& radii, double ee50, double ee90) {
    row(label, fmt::format("{}: off by {:+.3g} %; ee50 by {:+.3g} %",
                           format_quantity(radii.ee90, Dimension::kLength), 100 * ee90, 100 * ee50));
  };
  error("ee90 by rays", e.rays, e.ray_ee50, e.ray_ee90);
  row("R of the paper", fmt::format("{:.4g}", n.paper_ratio_r));
  row("  its verdict (R >> 1: rays)", paper_verdict(n.paper_ratio_r));
  row("  ours", facts.needed);
  row("why", facts.model_reason);
  row("models used", fmt::format("targets {}, surface {}", theory, facts.model));
  if (scene.use.too_simple(targets_are_given(study)))
    row("", "simpler than needed: the verdict of `fit` will be on " + facts.needed);
  json["rays_ee90_radius_m"] = e.rays.ee90;
  json["focal_sigma_m"] = scene.focal_sigma;
  json["paper_verdict"] = paper_verdict(n.paper_ratio_r);
  return json;
}

template <typename Row>
void check_cost(const Study& study, const Scene& scene, const RunOptions& options, const TermSet& terms,
                const TargetSets& targets, int threads, const Row& row, ordered_json* result) {
  const FitRates rates = rates_for(study, options);
  FitPrediction p;
  try {
    p = predict_fit(study, scene, terms, targets, rates, threads);
  } catch (const ComputationError& error) {  // a grid finer than there is: `fit` will say so, too
    row("predicted time of `fit`", fmt::format("not known: {}", error.what()));
    (*result)["predicted_seconds"] = nullptr;
    return;
  }
  row("predicted time of `fit`",
      fmt::format("{} on {} thread{}, pictures left out; {}", rounded_text(p.seconds), threads,
                  threads == 1 ? "" : "s",
                  p.search ? "searches vary by a factor of three" : "within a factor of two to three"));
  row("", "rates " + rates.source);
  ordered_json costs;
  for (const auto& [stage, cost] : p.stages) {
    std::string text = seconds_text(cost);
    if (stage == "iterations")
      text += fmt::format(" for {:.0f}{}{}{}{}", p.iterations, p.iterations_known ? "" : ", a typical number",
                          p.search ? ", of each of a typical number of sets" : "",
                          p.more_rays ? "; twice the rays the second time" : "",
                          study.fit.starts > 1
                              ? fmt::format("; as much for each further of {} starts", study.fit.starts)
                              : "");
    row("  " + stage, text);
    costs[stage] = cost;
  }
  (*result)["predicted_seconds"] = p.seconds;
  (*result)["prediction"] = {{"rates", rates.source},
                             {"iterations", p.iterations},
                             {"iterations_known", p.iterations_known},
                             {"stages_seconds", costs}};
}

// What a search for the fewest terms is expected to end with.
std::string expected_terms(const Scene& scene) {
  const OrderRange range = expected_orders(scene);
  if (range.wide)
    return fmt::format("chosen by the fit: the fewest plane waves that do (Zernikes need n > {})",
                       kLargestSearchedOrder);
  const auto count = [](int order) { return zernike_modes(2, order).size(); };
  return fmt::format("chosen by the fit: the fewest that do; n_max {} to {} expected, {} to {} terms",
                     range.low, range.high, count(range.low), count(range.high));
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
    result["scene"] = check_scene(study, scene, targets.theory, row);
  } else {
    row("models", fmt::format("targets {}, surface {}: {}", targets.theory, to_string(scene.use.model),
                              scene.use.reason));
  }
  const bool search = study.terms.automatic && scene.psd;
  row("terms", search ? expected_terms(scene)
                      : fmt::format("{} ({:.2f} % of the height variance)", terms.size(), 100 * captured));
  row("statistics", fmt::format("{} fitted, {} guides, {} held out; targets: {}", targets.fitted.size(),
                                targets.guides.size(), targets.held_out.size(), targets.theory));
  row("rays", scene.use.model == FocusModel::kWaves
                  ? std::string("none: waves on a grid of cells that the light itself decides")
              : study.trace.automatic_rays
                  ? fmt::format("chosen by the fit: {} or more for so many terms", first_rays(terms.size()))
                  : fmt::format("{}", study.trace.pupil.rays));
  result["terms"] = {{"count", terms.size()}, {"captured_fraction", captured}};
  if (search) {
    const OrderRange range = expected_orders(scene);
    result["terms"]["automatic"] = {
        {"family", range.wide ? "fourier" : "zernike"}, {"n_low", range.low}, {"n_high", range.high}};
  }
  check_cost(study, scene, options, terms, targets, threads, row, &result);
  result["warnings"] = ordered_json::array();
  for (const Warning& warning : warnings) {
    result["warnings"].push_back({{"code", warning.code}, {"message", warning.message}});
    text += fmt::format("\n  {}: {}\n", warning.code, warning.message);
  }
  if (options.paper_table) {
    text += "\n";
    result["paper_table"] = paper_table(*options.paper_table, study.mirror.focal_length, &text);
  }
  if (table) *table = text;
  return result;
}

}  // namespace aberfit
