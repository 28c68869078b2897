#include "aberfit/report/band_shares.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "aberfit/core/units.h"
#include "json_number.h"
#include "paragraph.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr const char* kUse =
    "Give the surface the terms (coefficients.csv or an export) and, as its scatter model, the scatter "
    "function "
    "(scatter.csv): together they are this mirror.";
constexpr const char* kBeware =
    "Not the whole PSD: a scatter model of all of it on a surface that has the terms counts their roughness "
    "twice.";

}  // namespace

nlohmann::ordered_json to_json(const BandShares& shares, const EquivalentSurface& surface) {
  const auto part = [](double height, double slope) -> nlohmann::ordered_json {
    return {{"rms_height_m", json_number(height)}, {"rms_slope_per_axis", json_number(slope)}};
  };
  nlohmann::ordered_json scatter = part(shares.rest_rms, shares.rest_slope);
  scatter["scatter_rms_rad"] = json_number(shares.rest_scatter);
  scatter["tis"] = json_number(shares.tis);
  return {{"cut_per_m", json_number(shares.cut)},
          {"automatic", shares.automatic},
          {"specified_terms", part(shares.low_rms, shares.low_slope)},
          {"terms", part(surface.rms_height, surface.rms_slope_per_axis)},
          {"scatter", std::move(scatter)},
          {"sum", part(std::hypot(surface.rms_height, shares.rest_rms),
                       std::hypot(surface.rms_slope_per_axis, shares.rest_slope))},
          {"spread_in_tolerances", json_number(shares.spread)},
          {"spread_of", shares.spread_of},
          {"reason", shares.reason},
          {"use", kUse},
          {"beware", kBeware}};
}

std::string band_lines(const BandShares& shares, const EquivalentSurface& surface) {
  std::string text = paragraph("Band", shares.reason);
  const auto squares = [](double a, double b, Dimension dimension) {
    return fmt::format("{} and {}, together {}", format_quantity(a, dimension), format_quantity(b, dimension),
                       format_quantity(std::hypot(a, b), dimension));
  };
  if (!(shares.cut > 0)) return text;
  text +=
      paragraph("", fmt::format("Terms and scatter: RMS height {}; RMS slope {} per axis.",
                                squares(surface.rms_height, shares.rest_rms, Dimension::kLength),
                                squares(surface.rms_slope_per_axis, shares.rest_slope, Dimension::kAngle)));
  return text + paragraph("", std::string(kUse) + " " + kBeware);
}

}  // namespace aberfit
