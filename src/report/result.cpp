#include "aberfit/report/result.h"

#include <fmt/core.h>

#include <Eigen/Core>
#include <boost/version.hpp>
#include <cassert>
#include <cmath>

#include "aberfit/report/band_shares.h"
#include "aberfit/report/character.h"
#include "aberfit/report/frontier.h"
#include "aberfit/scene/zernike.h"
#include "json_number.h"
#include "map_report.h"
#include "statistic_label.h"
#include "target_json.h"

namespace aberfit {
using namespace internal;

namespace {

Json metrics_json(const std::vector<EquivalenceMetric>& metrics) {
  Json json = Json::array();
  for (const EquivalenceMetric& metric : metrics) {
    json.push_back(
        {{"name", metric.name},
         {"held_out", metric.held_out},
         {"target", json_number(metric.target)},
         {"model", json_number(metric.model)},
         {"relative_difference", json_number(metric.relative_difference)},
         {"difference", json_number(metric.difference)},
         {"standard_error", json_number(metric.standard_error)},
         {"degrees_of_freedom", json_number(metric.degrees_of_freedom)},
         {"interval", Json::array({json_number(metric.interval[0]), json_number(metric.interval[1])})},
         {"margin", json_number(metric.margin)},
         {"verdict", to_string(metric.verdict)}});
    if (metric.model_error > 0) json.back()["model_error"] = json_number(metric.model_error);
    if (metric.spread > 0) {
      json.back()["spread"] = json_number(metric.spread);
      json.back()["difference_in_spreads"] = json_number(metric.difference / metric.spread);
    }
    if (std::isnan(metric.tolerance_share)) continue;
    json.back()["share_difference"] = json_number(metric.share_difference);
    json.back()["tolerance_share"] = json_number(metric.tolerance_share);
  }
  return json;
}

Json targets_json(const ResultDocument& result, const std::vector<std::string>& names) {
  Json json = Json::object();
  for (std::size_t k = 0; k < names.size(); ++k) json[names[k]] = target_json(result.targets[k]);
  return json;
}

Json surface_json(const EquivalentSurface& surface) {
  return {{"rms_height_m", json_number(surface.rms_height)},
          {"rms_slope_per_axis", json_number(surface.rms_slope_per_axis)},
          {"g", json_number(surface.g)},
          {"kappa", json_number(surface.kappa)},
          {"needed", surface.needed},
          {"prior_height_factor", json_number(surface.prior_height_factor)},
          {"captured_fraction", json_number(surface.captured_fraction)}};
}

// How heights and slopes were computed from the coefficients; a family of terms that is absent has no method.
Json operator_json(const OperatorChoice& choice) {
  return {{"zernike", choice.zernike ? Json(to_string(*choice.zernike)) : Json(nullptr)},
          {"fourier", choice.fourier ? Json(to_string(*choice.fourier)) : Json(nullptr)},
          {"reason", choice.reason}};
}

Json fit_json(const ResultDocument& result) {
  const FitResult& fit = result.fit;
  Json json = {{"status", to_string(fit.status)},
               {"message", fit.message},
               {"interrupted", result.interrupted},
               {"stopped_by", result.interrupted ? Json(result.stopped_by) : Json(nullptr)},
               {"iterations", fit.iterations},
               {"evaluations", fit.evaluations},
               {"seconds", json_number(fit.seconds)},
               {"initial_cost", json_number(fit.initial_cost)},
               {"final_cost", json_number(fit.final_cost)},
               {"rank", fit.rank},
               {"null_directions", fit.null_directions},
               {"terms", result.terms.size()},
               {"pupil_points", result.rays},
               {"operator", operator_json(fit.operator_choice)},
               {"equivalent_surface", surface_json(result.surface)},
               {"singular_values", json_numbers(fit.singular_values)}};
  if (result.ray_choice) json["ray_choice"] = to_json(*result.ray_choice);
  if (result.frontier) json["frontier"] = to_json(*result.frontier);
  return json;
}

// Errors of each segment of the aperture.
template <typename Value, typename Spread>
Json segments_json(const TermSet& terms, const Value& value, const Spread& spread) {
  Json list = Json::array();
  Eigen::Index k = terms.segments_begin();
  for (const Segments::Segment& segment : terms.segments->all()) {
    Json one = {{"x_m", json_number(segment.centre[0])},
                {"y_m", json_number(segment.centre[1])},
                {"radius_m", json_number(segment.radius)}};
    const auto add = [&](const char* name) {
      one[fmt::format("{}_m", name)] = value(k);
      one[fmt::format("{}_std_m", name)] = spread(k++);
    };
    if (terms.segments->piston() > 0) add("piston");
    if (terms.segments->tip_tilt() > 0)
      for (const char* name : {"slope_x", "slope_y"}) add(name);
    list.push_back(std::move(one));
  }
  return list;
}

Json coefficients_json(const ResultDocument& result) {
  const TermSet& terms = result.terms;
  const Eigen::VectorXd &c = result.fit.coefficients, &std = result.fit.coefficient_std;
  if (c.size() == 0) return Json::object();
  assert(c.size() == terms.size());
  const auto value = [&](Eigen::Index i) { return json_number(c[i]); };
  const auto spread = [&](Eigen::Index i) { return i < std.size() ? json_number(std[i]) : Json(nullptr); };

  Json zernike = Json::array(), fourier = Json::array(), spherical = Json::object();
  for (std::size_t i = 0; i < terms.zernike.size(); ++i) {
    const ZernikeMode& mode = terms.zernike[i];
    const Eigen::Index k = Eigen::Index(i);
    zernike.push_back({{"n", mode.n},
                       {"m", mode.m},
                       {"noll", noll_index(mode)},
                       {"value_m", value(k)},
                       {"std_m", spread(k)}});
  }
  for (std::size_t i = 0; i < terms.fourier.size(); ++i) {
    const Eigen::Index k = terms.fourier_begin() + 2 * Eigen::Index(i);
    fourier.push_back({{"fx_per_m", json_number(terms.fourier[i].fx)},
                       {"fy_per_m", json_number(terms.fourier[i].fy)},
                       {"cos_m", value(k)},
                       {"sin_m", value(k + 1)},
                       {"cos_std_m", spread(k)},
                       {"sin_std_m", spread(k + 1)}});
  }
  for (std::size_t i = 0; i < terms.spherical.size(); ++i) {
    const Eigen::Index k = terms.spherical_begin() + Eigen::Index(i);
    const int power = terms.spherical[i];
    spherical[fmt::format("c{}", power)] = {
        {"value_m", value(k)},
        {"std_m", spread(k)},
        {"coefficient", json_number(c[k] / std::pow(terms.radius, power))}};
  }
  Json json = {{"radius_m", json_number(terms.radius)},
               {"zernike", zernike},
               {"fourier", fourier},
               {"spherical", spherical}};
  if (terms.of_a_segment() > 0) json["segments"] = segments_json(terms, value, spread);
  return json;
}

Json statistics_json(const ResultDocument& result, const std::vector<std::string>& names) {
  Json json = Json::object();
  const auto add = [&](const char* key, const Eigen::VectorXd& values) {
    if (values.size() == 0) return;
    assert(values.size() == Eigen::Index(names.size()));
    Json list = Json::object();
    for (std::size_t k = 0; k < names.size(); ++k) list[names[k]] = json_number(values[Eigen::Index(k)]);
    json[key] = list;
  };
  add("start", result.start);
  add("fitted", result.fitted);
  add("validated", result.validated);
  add("posterior_std", result.posterior_std);
  return json;
}

Json spectrum_json(const ResultDocument& result) {
  Json bins = Json::array();
  for (const SpectrumBin& bin : result.spectrum)
    bins.push_back({{"low_per_m", bin.low},
                    {"high_per_m", bin.high},
                    {"target_m4", json_number(bin.target)},
                    {"fitted_m4", json_number(bin.fitted)},
                    {"tolerance", bin.tolerance}});
  return bins;
}

// Light's answer; `metrics` only where they are not those of the fit.
Json light_json(const ResultDocument& result) {
  if (!result.light)
    return {{"decides", true},
            {"theory", result.theory},
            {"model", "waves"},
            {"verdict", to_string(result.verdict)}};
  const LightJudgement& light = *result.light;
  Json json = {{"decides", light.decides},
               {"theory", light.theory},
               {"model", "waves"},
               {"verdict", light.metrics.empty() ? Json(nullptr) : Json(to_string(light.verdict))}};
  if (!light.obstacle.empty()) json["obstacle"] = light.obstacle;
  json["metrics"] = metrics_json(light.metrics);
  return json;
}

Json equivalence_json(const ResultDocument& result) {
  Json json = {{"verdict", to_string(result.verdict)}, {"metrics", metrics_json(result.metrics)}};
  if (result.fit.status == FitStatus::kNotRun || (result.map && !result.has_roughness)) return json;
  json["light"] = light_json(result);
  if (result.perfect)
    json["perfect_mirror"] = {{"mismatch_tolerances", json_number(result.perfect->mismatch)},
                              {"statistic", result.perfect->statistic}};
  return json;
}

std::string compiler() {
#if defined(__clang__)
  return fmt::format("clang {}.{}.{}", __clang_major__, __clang_minor__, __clang_patchlevel__);
#elif defined(__GNUC__)
  return fmt::format("gcc {}.{}.{}", __GNUC__, __GNUC_MINOR__, __GNUC_PATCHLEVEL__);
#else
  return "unknown";
#endif
}

}  // namespace

Provenance make_provenance(std::uint64_t seed, int threads) {
  Provenance provenance{ABERFIT_VERSION, seed, threads, {}};
  provenance.libraries = {
      {"compiler", compiler()},
      {"eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
      {"boost",
       fmt::format("{}.{}.{}", BOOST_VERSION / 100000, BOOST_VERSION / 100 % 1000, BOOST_VERSION % 100)},
      {"nlohmann-json", fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                                    NLOHMANN_JSON_VERSION_PATCH)},
      {"fmt", fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100)}};
  return provenance;
}

Json to_json(const Provenance& provenance) {
  Json libraries = Json::object();
  for (const auto& [name, version] : provenance.libraries) libraries[name] = version;
  return {{"version", provenance.version},
          {"seed", provenance.seed},
          {"threads", provenance.threads},
          {"libraries", libraries}};
}

Json mean_light_json(const SpecifiedLight& light) {
  Json json = {{"theory", light.theory}};
  for (const SpecifiedValue& one : light.values) {
    if (!one.is_width) {
      json[one.key] = json_number(one.value);
      continue;
    }
    json[one.key + "_m"] = json_number(one.value);
    json[one.key + "_rad"] = json_number(one.value / light.focal_length);
  }
  for (const SpecifiedLight::Line& line : light.lines)
    json["lines"].push_back({{"wavelength_m", line.wavelength},
                             {"share", line.share},
                             {"ee50_diameter_m", json_number(line.ee50_diameter)},
                             {"ee80_diameter_m", json_number(line.ee80_diameter)}});
  return json;
}

namespace {

Json spread_json(const MirrorSpread& spread) {
  Json json = Json::array();
  for (const StatisticSpread& one : spread.statistics)
    json.push_back({{"name", one.name},
                    {"relative", json_number(one.relative)},
                    {"tolerances", json_number(one.tolerances)}});
  return json;
}

}  // namespace

Json scene_json(const FitOutcome& result) {
  if (!result.has_roughness) return nullptr;
  const SceneNumbers& scene = result.scene;
  Json json = {{"rms_height_m", json_number(scene.rms_height)},
               {"rms_slope_per_axis", json_number(scene.rms_slope_per_axis)},
               {"correlation_length_m", json_number(scene.correlation_length)},
               {"n_eff", json_number(scene.n_eff)},
               {"g", json_number(scene.g)},
               {"kappa", json_number(scene.kappa)},
               {"tis", json_number(scene.tis)},
               {"paper_ratio_r", json_number(scene.paper_ratio_r)},
               {"airy_ee90_m", json_number(scene.airy_ee90)},
               {"kappa_rule_allows_rays", scene.kappa_rule_allows_rays},
               {"theory", result.theory},
               {"model", result.model},
               {"needed", result.needed},
               {"reason", result.model_reason.empty() ? scene.reason : result.model_reason}};
  if (const auto& errors = result.errors) {
    json["ghs"] = {{"ee50_radius_m", json_number(errors->ghs.ee50)},
                   {"ee80_radius_m", json_number(errors->ghs.ee80)},
                   {"ee90_radius_m", json_number(errors->ghs.ee90)},
                   {"core_share", json_number(1 - scene.tis)}};
    json["model_error"] = {{"ray_ee50", json_number(errors->ray_ee50)},
                           {"ray_ee90", json_number(errors->ray_ee90)}};
  }
  if (!result.mean_light.values.empty()) json["mean_light"] = mean_light_json(result.mean_light);
  if (const StatisticSpread* worst = result.spread.worst())
    json["spread"] = {{"worst", worst->name}, {"statistics", spread_json(result.spread)}};
  if (result.band) json["band"] = to_json(*result.band);
  return json;
}

Json to_json(const ResultDocument& result, const Json& study) {
  const std::vector<std::string> names = unique_names(result.targets);
  Json json = json_document(result.kind, study);
  json["scene"] = scene_json(result);
  json["target"] = targets_json(result, names);
  json["fit"] = fit_json(result);
  json["coefficients"] = coefficients_json(result);
  json["statistics"] = statistics_json(result, names);
  if (result.shares) json["split"] = to_json(*result.shares, result.scatter, result.surface);
  if (!result.spectrum.empty()) json["spectrum"] = spectrum_json(result);
  if (result.map) {
    json["map"] = map_json(result);
    json["map"]["clear"] = clear_json(result.clear);
  }
  if (result.character) json["character"] = to_json(*result.character);
  json["equivalence"] = equivalence_json(result);
  json["warnings"] = json_warnings(result.warnings);
  json["provenance"] = to_json(result.provenance);
  return json;
}

}  // namespace aberfit
