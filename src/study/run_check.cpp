#include <fmt/format.h>

#include "aberfit/core/parallel.h"
#include "aberfit/core/units.h"
#include "aberfit/scene/characterisation.h"
#include "aberfit/study/read_study.h"
#include "aberfit/study/run.h"
#include "run_map_fit.h"
#include "scene.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;

// Rates of one AVX-512 core, term-points per second, as the docstring of src/terms/surface_operator.cpp
// states them; rounded down, because a prediction that is beaten annoys nobody.
constexpr double kOperatorRate = 3e9;
// Share of the rays that one EE statistic's gradient touches at the default smoothing.
constexpr double kTouchedShare = 0.07;
constexpr double kStatisticRate = 4e7;  // rays per second for one statistic, exact or smooth
constexpr int kTypicalIterations = 15;

double predicted_seconds(double rays, double terms, double statistics, int threads) {
  const double forward = rays * terms / kOperatorRate + statistics * rays / kStatisticRate / 8;
  const double adjoint = statistics * kTouchedShare * rays * terms / kOperatorRate;
  const double fresh = 8 * (rays * terms / kOperatorRate + statistics * rays / kStatisticRate);
  return (kTypicalIterations * (2 * forward + adjoint) + fresh) / threads;
}

// A study of a measured map has no specification: what is fitted, and where it comes from.
ordered_json check_map_study(const Study& study, std::string* table) {
  const HeightMap map = load_map(study);
  const TermSet terms = map_terms(study, aperture_radius(study.aperture));
  std::string text = study.title.empty() ? "" : study.title + "\n\n";
  text += fmt::format("  {:<34} {} x {} points, {} valid, pitch {}\n", "map", map.columns(), map.rows(),
                      valid_count(map), format_quantity(map.pitch_x, Dimension::kLength));
  text += fmt::format("  {:<34} {} by least squares\n", "terms", terms.size());
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
          {"warnings", ordered_json::array()}};
}

}  // namespace

ordered_json run_check(const Study& study, const RunOptions& options, std::string* table) {
  if (study.target.map) return check_map_study(study, table);
  const int threads = options.threads > 0 ? options.threads : available_threads();
  const Scene scene = make_scene(study);
  double captured = 0;
  const TermSet terms = make_terms(study, scene, &captured);
  const TargetSets targets = make_targets(study, scene, threads);
  const Warnings warnings = scene_warnings(study, scene, terms, captured);
  const double rays = double(study.trace.pupil.rays);
  const auto statistics = double(targets.fitted.size() + targets.guides.size());
  const double seconds = predicted_seconds(rays, double(terms.size()), statistics, threads);

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
  row("predicted time of `fit`", fmt::format("{:.1f} s on {} thread{} (a rough guide: within a factor 3)",
                                             seconds, threads, threads == 1 ? "" : "s"));
  result["terms"] = {{"count", terms.size()}, {"captured_fraction", captured}};
  result["predicted_seconds"] = seconds;
  result["warnings"] = ordered_json::array();
  for (const Warning& warning : warnings) {
    result["warnings"].push_back({{"code", warning.code}, {"message", warning.message}});
    text += fmt::format("\n  {}: {}\n", warning.code, warning.message);
  }
  if (table) *table = text;
  return result;
}

}  // namespace aberfit
