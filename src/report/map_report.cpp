#include "map_report.h"

#include <fmt/format.h>

#include <cmath>

#include "aberfit/core/text.h"
#include "aberfit/core/units.h"
#include "paragraph.h"

namespace aberfit::internal {
namespace {

Json panel_json(const MapPanel& panel) {
  return {{"rms_m", json_number(panel.rms)},
          {"peak_to_valley_m", json_number(panel.peak_to_valley)},
          {"rms_slope_x", json_number(panel.rms_slope_x)},
          {"rms_slope_y", json_number(panel.rms_slope_y)}};
}

Json lit_json(const LitSurface& lit) {
  Json json = {{"strehl", json_number(lit.strehl)},
               {"ee50_radius_m", json_number(lit.ee50)},
               {"ee80_radius_m", json_number(lit.ee80)},
               {"ee90_radius_m", json_number(lit.ee90)},
               {"spot_fwhm_m", json_number(lit.spot_fwhm)}};
  if (!lit.obstacle.empty()) json["obstacle"] = lit.obstacle;
  return json;
}

Json map_light_json(const MapLight& light) {
  Json json = {{"cells", light.cells}, {"filled_share", json_number(light.filled_share)}};
  for (std::size_t k = 0; k < light.columns().size(); ++k)
    json[kMapColumns[k].key] = lit_json(*light.columns()[k]);
  const ResidualPsd& rest = light.rest;
  json["residual_psd"] = {{"f_min_per_m", json_number(rest.f_min)},
                          {"f_max_per_m", json_number(rest.f_max)},
                          {"rms_height_m", json_number(rest.rms_height)},
                          {"residual_tis", json_number(rest.tis)}};
  if (!rest.obstacle.empty()) json["residual_psd"]["obstacle"] = rest.obstacle;
  return json;
}

std::string rest_words(const MapLight& light, const MapPanels& panels) {
  const ResidualPsd& rest = light.rest;
  if (!rest.obstacle.empty()) return "of the residual: none, " + rest.obstacle;
  if (!(rest.rms_height > 0)) return "of the residual: none, the terms leave nothing that light could see";
  return fmt::format("of the residual: {} to {}, RMS {} (of the map {}), TIS {}",
                     format_quantity(rest.f_min, Dimension::kSpatialFrequency),
                     format_quantity(rest.f_max, Dimension::kSpatialFrequency), metres_text(rest.rms_height),
                     metres_text(panels.residual.rms), format_percent(rest.tis));
}

}  // namespace

Json map_json(const FitOutcome& outcome) {
  const MapFitResult& map = *outcome.map;
  Json json = {{"points", map.points},
               {"held_out_points", map.held_out_points},
               {"rms_map_m", json_number(map.rms_map)},
               {"rms_residual_m", json_number(map.rms_residual)},
               {"rms_held_out_m", json_number(map.rms_held_out)},
               {"independent_points", json_number(map.independent_points)},
               {"condition_number", json_number(map.condition_number)},
               {"rank", map.rank}};
  if (const auto& panels = outcome.map_panels) {
    json["pitch_x_m"] = json_number(panels->measured.map.pitch_x);
    json["pitch_y_m"] = json_number(panels->measured.map.pitch_y);
    json["heights"] = {{"measured", panel_json(panels->measured)},
                       {"fitted", panel_json(panels->fitted)},
                       {"residual", panel_json(panels->residual)}};
  }
  if (outcome.map_light) json["light"] = map_light_json(*outcome.map_light);
  return json;
}

std::string map_light_table(const FitOutcome& outcome) {
  if (!outcome.map_light || !outcome.map_panels) return "";
  const MapLight& light = *outcome.map_light;
  std::string out = fmt::format("\nLight of the map in the focus, by waves\n  {:<20}", "");
  for (const MapColumnName& name : kMapColumns) out += fmt::format(" {:>15}", name.label);
  out += '\n';
  const auto row = [&](const char* name, double LitSurface::*value, Dimension dimension) {
    out += fmt::format("  {:<20}", name);
    for (const LitSurface* lit : light.columns())
      out += fmt::format(" {:>15}", four_digits(lit->*value, dimension));
    out += '\n';
  };
  row("Strehl ratio", &LitSurface::strehl, Dimension::kNumber);
  row("ee50 radius", &LitSurface::ee50, Dimension::kLength);
  row("ee80 radius", &LitSurface::ee80, Dimension::kLength);
  row("ee90 radius", &LitSurface::ee90, Dimension::kLength);
  row("spot FWHM", &LitSurface::spot_fwhm, Dimension::kLength);
  for (std::size_t k = 0; k < light.columns().size(); ++k)
    if (const std::string& obstacle = light.columns()[k]->obstacle; !obstacle.empty())
      out += paragraph("", std::string(kMapColumns[k].label) + ": no light, " + obstacle);
  out += paragraph(
      "Pupil",
      fmt::format("all of the aperture on {} points of the map, without piston and tilt of the mount; "
                  "{} of it has no height and has that of the terms, in all columns alike",
                  light.cells, format_percent(light.filled_share)));
  return out + paragraph("PSD", rest_words(light, *outcome.map_panels));
}

}  // namespace aberfit::internal
