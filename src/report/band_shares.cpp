#include "aberfit/report/band_shares.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "aberfit/core/constants.h"
#include "aberfit/core/units.h"
#include "aberfit/report/scatter_table.h"
#include "json_number.h"
#include "paragraph.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr const char* kUse =
    "Give the surface the terms (coefficients.csv or an export) and, as its scatter model, the scatter "
    "function (scatter.csv): together they are this mirror.";
constexpr const char* kBeware =
    "Not the whole PSD: a scatter model of all of it on a surface that has the terms counts their roughness "
    "twice.";

constexpr const char* kUseWithoutTerms =
    "Give a smooth surface the scatter function (scatter.csv) as its scatter model: that is this mirror.";

constexpr const char* kResidual =
    "What the terms leave of the map is not added to the sum: the scatter stands for it, as specified.";

std::string residual_words(const BandShares& shares) {
  if (!std::isfinite(shares.map_residual)) return "";
  std::string text = fmt::format(" Residual of the map {}", metres_text(shares.map_residual));
  if (std::isfinite(shares.specified_residual))
    text += fmt::format(", of its specification {}", metres_text(shares.specified_residual));
  return text + (shares.rest_rms > 0 ? ": not added, the scatter stands for it." : ".");
}

Json abg_json(const AbgFit& fit) {
  const auto of_model = [&](double value) { return json_number(fit.describes() ? value : kNaN); };
  return {{"describes", fit.describes()},
          {"a_per_sr", of_model(fit.model.a)},
          {"b", of_model(fit.model.b)},
          {"g", of_model(fit.model.g)},
          {"theta_min_rad", json_number(fit.theta_min)},
          {"theta_max_rad", json_number(fit.theta_max)},
          {"largest_error", json_number(fit.largest_error)},
          {"rms_error", json_number(fit.rms_error)},
          {"abg_tis", of_model(fit.tis)}};
}

std::string abg_words(const AbgFit& fit) {
  if (!fit.describes()) return no_abg(fit) + ".";
  return fmt::format(
      "ABg: A {:.4g} /sr, B {:.4g}, g {:.4g}{}; from {} to {} within {} (RMS {}), its own TIS {}.",
      fit.model.a, fit.model.b, fit.model.g, fit.at_least_b ? " (the least B)" : "",
      format_quantity(fit.theta_min, Dimension::kAngle), format_quantity(fit.theta_max, Dimension::kAngle),
      format_percent(fit.largest_error), format_percent(fit.rms_error), format_percent(fit.tis));
}

// The best, and what the form that every program takes would miss.
std::string abg_lines(const std::vector<AbgFit>& fits) {
  if (fits.empty()) return "";
  std::string text = abg_words(fits.back());
  if (fits.size() > 1 && fits.back().describes())
    text += fmt::format(" With B above 1e-12, as OpticStudio takes it, {}: take the table there.",
                        format_percent(fits.front().largest_error));
  return paragraph("", text);
}

}  // namespace

Json to_json(const BandShares& shares, const std::optional<ScatterOfRest>& of_rest,
             const std::optional<EquivalentSurface>& surface) {
  const auto part = [](double height, double slope) -> Json {
    return {{"rms_height_m", json_number(height)}, {"rms_slope_per_axis", json_number(slope)}};
  };
  Json scatter = part(shares.rest_rms, shares.rest_slope);
  scatter["scatter_rms_rad"] = json_number(shares.rest_scatter);
  scatter["rest_tis"] = json_number(shares.tis);
  if (of_rest) {
    scatter["abg"] = Json::array();
    for (const AbgFit& fit : of_rest->abg) scatter["abg"].push_back(abg_json(fit));
  }
  Json json = {{"cut_per_m", json_number(shares.cut)},
               {"automatic", shares.automatic},
               {"specified_terms", part(shares.low_rms, shares.low_slope)},
               {"scatter", std::move(scatter)},
               {"spread_in_tolerances", json_number(shares.spread)},
               {"spread_of", shares.spread_of},
               {"rms_height_spread", json_number(shares.height_spread)},
               {"rms_slope_spread", json_number(shares.slope_spread)},
               {"reason", shares.reason}};
  if (!surface) return json;
  json["terms"] = part(surface->rms_height, surface->rms_slope_per_axis);
  json["sum"] = part(std::hypot(surface->rms_height, shares.rest_rms),
                     std::hypot(surface->rms_slope_per_axis, shares.rest_slope));
  if (std::isfinite(shares.map_residual))
    json["map_residual"] = {{"rms_height_m", json_number(shares.map_residual)},
                            {"specified_rms_height_m", json_number(shares.specified_residual)},
                            {"meaning", kResidual}};
  if (!(shares.rest_rms > 0)) return json;
  json["use"] = shares.cut > 0 ? kUse : kUseWithoutTerms;
  if (shares.cut > 0) json["beware"] = kBeware;
  return json;
}

std::string band_lines(const BandShares& shares, const std::optional<ScatterOfRest>& scatter,
                       const EquivalentSurface& surface) {
  std::string text = paragraph("Band", shares.reason);
  const auto squares = [](double a, double b, Dimension dimension) {
    return fmt::format("{} and {}, together {}", format_quantity(a, dimension), format_quantity(b, dimension),
                       format_quantity(std::hypot(a, b), dimension));
  };
  if (scatter) text += abg_lines(scatter->abg);
  if (!(shares.cut > 0)) return text + paragraph("", kUseWithoutTerms);
  text += paragraph("", fmt::format("Terms and scatter: RMS height {}; RMS slope {} per axis.{}",
                                    squares(surface.rms_height, shares.rest_rms, Dimension::kLength),
                                    squares(surface.rms_slope_per_axis, shares.rest_slope, Dimension::kAngle),
                                    residual_words(shares)));
  if (!(shares.rest_rms > 0)) return text;
  return text + paragraph("", std::string(kUse) + " " + kBeware);
}

}  // namespace aberfit
