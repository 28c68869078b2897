#include "aberfit/report/character.h"

#include <fmt/format.h>

#include "aberfit/core/units.h"
#include "aberfit/method/constants.h"
#include "json_number.h"
#include "paragraph.h"

namespace aberfit {
using namespace internal;

namespace {

Json to_json(const BesideDraws& one) {
  return {{"value", json_number(one.value)},
          {"draws_mean", json_number(one.mean)},
          {"draws_low", json_number(one.low)},
          {"draws_high", json_number(one.high)},
          {"inside", one.inside()}};
}

Json to_json(const std::optional<BesideDraws>& one) { return one ? to_json(*one) : Json(nullptr); }

Json others_json(const std::vector<OtherLight>& others) {
  Json list = Json::array();
  for (const OtherLight& other : others) {
    Json json = {{"wavelength_m", json_number(other.wavelength)}, {"stop", json_number(other.stop)}};
    if (!other.obstacle.empty()) {
      json["obstacle"] = other.obstacle;
    } else {
      json["worst_tolerances"] = json_number(other.worst);
      json["worst_share"] = json_number(other.fraction);
      json["draws_rms_tolerances"] = json_number(other.draws);
    }
    list.push_back(json);
  }
  return list;
}

std::string row(const std::string& what, const BesideDraws& one) {
  return fmt::format("  {:<32} {:>10.3f} {:>10.3f}  {:>21}  {}\n", what, one.value, one.mean,
                     fmt::format("{:.3f} .. {:.3f}", one.low, one.high), one.inside() ? "inside" : "OUTSIDE");
}

std::string other_row(const OtherLight& other) {
  const std::string what = other.stop < 1
                               ? fmt::format("stop of {:.3g} %", 100 * other.stop)
                               : fmt::format("{:.3g} wavelengths, {}", other.wavelength_ratio,
                                             format_quantity(other.wavelength, Dimension::kLength));
  if (!other.obstacle.empty()) return paragraph("", what + ": no answer: " + other.obstacle);
  return fmt::format("  {:<32} {:>10.2f} {:>10.2f}  ee{:g}\n", what, other.worst, other.draws,
                     100 * other.fraction);
}

}  // namespace

nlohmann::ordered_json to_json(const Character& character) {
  Json psd = Json::array(), zones = Json::array();
  for (const CharacterBin& bin : character.psd) {
    Json json = {{"f_low_per_m", json_number(bin.low)},
                 {"f_high_per_m", json_number(bin.high)},
                 {"specification_m4", json_number(bin.specification)}};
    json.update(to_json(bin.ratio));
    psd.push_back(json);
  }
  for (const ZoneSlope& zone : character.zones) {
    Json json = {{"rho_min", json_number(zone.rho_min)}, {"rho_max", json_number(zone.rho_max)}};
    json.update(to_json(zone.ratio));
    zones.push_back(json);
  }
  Json json = {{"of_this_roughness", character.fault().empty()},
               {"fault", character.fault()},
               {"draws", character.draws},
               {"confidence", law::kCharacterConfidence},
               {"psd_ratio", psd},
               {"zones", zones},
               {"slope_x_over_y", to_json(character.slope_x_over_y)},
               {"length_over_width", to_json(character.length_over_width)},
               {"bright_share", to_json(character.bright_share)}};
  if (!character.light_obstacle.empty()) json["light_obstacle"] = character.light_obstacle;
  json["other_light"] = others_json(character.others);
  return json;
}

std::string character_words(const Character& character, Verdict verdict) {
  const std::string fault = character.fault();
  if (fault.empty()) return "PSD and shape those of draws";
  return (verdict == Verdict::kEquivalent ? "but not of this roughness: " : "not of this roughness: ") +
         fault;
}

std::string character_table(const Character& character) {
  std::string out = fmt::format("\n{:<34} {:>10} {:>10}  {:>21}\n",
                                fmt::format("Character, beside {} draws", character.draws), "fitted", "draws",
                                fmt::format("{:g} % of draws", 100 * law::kCharacterConfidence));
  for (const CharacterBin& bin : character.psd)
    out += row(fmt::format("PSD {:.4g} .. {:.4g} /m, ratio", bin.low, bin.high), bin.ratio);
  for (const ZoneSlope& zone : character.zones)
    out += row(fmt::format("RMS slope {:.2f} .. {:.2f} R, share", zone.rho_min, zone.rho_max), zone.ratio);
  out += row("RMS slope, x over y", character.slope_x_over_y);
  if (character.length_over_width) out += row("image, length over width", *character.length_over_width);
  if (character.bright_share) out += row("light in brightest 1 % beyond ee35", *character.bright_share);
  if (!character.light_obstacle.empty())
    out += paragraph("", "no image is looked at: " + character.light_obstacle);
  if (character.others.empty()) return out;
  out += fmt::format("\n{:<34} {:>10} {:>10}\n", "Worst of ee35 to ee90, tolerances", "fitted", "draws rms");
  for (const OtherLight& other : character.others) out += other_row(other);
  return out;
}

}  // namespace aberfit
