#include "aberfit/report/ceilings_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "aberfit/core/constants.h"
#include "json_number.h"
#include "paragraph.h"
#include "picture.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kSquareNanometreMillimetre = 1e-21;  // [m^3], what drawings carry
constexpr double kPerMillimetre = 1000;

// Fields of a table, in the units of drawings.
std::string rms_text(double rms) { return std::isfinite(rms) ? metres_text(rms) : "any"; }
std::string level_text(double level) {
  return std::isfinite(level) ? fmt::format("{:.4g}", level / kSquareNanometreMillimetre) : "any";
}
std::string binding_text(const Ceilings& ceilings, double rms, std::size_t binding) {
  return std::isfinite(rms) ? ceilings.budgets[binding].key : "-";
}

// Of what has a height: from the least to the most.
template <typename Items>
std::string range_text(const Items& items) {
  double least = kInfinity, most = 0;
  for (const auto& item : items) {
    if (!std::isfinite(item.rms)) continue;
    least = std::min(least, item.rms);
    most = std::max(most, item.rms);
  }
  if (!(most > 0)) return "any height";
  return metres_text(least) + (least == most ? "" : " to " + metres_text(most)) + " RMS";
}

std::string octave_rows(const Ceilings& ceilings) {
  std::string text = fmt::format("  {:>12} {:>13} {:>13} {:>16}  {}\n", "f [1/mm]", "cycles across", "RMS",
                                 "PSD [nm^2 mm]", "what ends it");
  for (const OctaveCeiling& octave : ceilings.octaves)
    text += fmt::format("  {:>12.4g} {:>13.4g} {:>13} {:>16}  {}\n", octave.frequency / kPerMillimetre,
                        octave.frequency * ceilings.across, rms_text(octave.rms),
                        level_text(octave.profile_psd), binding_text(ceilings, octave.rms, octave.binding));
  return text;
}

std::string line_rows(const Ceilings& ceilings) {
  std::string text = fmt::format("  {:>6} {:>14} {:>13} {:>11} {:>16}  {}\n", "B", "A [nm^2 mm]", "RMS",
                                 "headroom", "nearest [1/mm]", "what ends it");
  for (const LineCeiling& line : ceilings.lines) {
    const bool known = std::isfinite(line.headroom);
    text += fmt::format("  {:>6.4g} {:>14} {:>13} {:>11} {:>16}  {}\n", line.exponent, level_text(line.level),
                        rms_text(line.rms), known ? fmt::format("{:.3g}", line.headroom) : "-",
                        known ? fmt::format("{:.4g}", line.closest / kPerMillimetre) : "-",
                        binding_text(ceilings, line.rms, line.binding));
  }
  return text;
}

std::string shown_bounds(const Ceilings& ceilings) {
  std::string text;
  for (const Budget& budget : ceilings.budgets)
    text += (text.empty() ? "" : ", ") + budget.key + " " + budget.bound;
  return text;
}

}  // namespace

Json to_json(const Ceilings& ceilings, const Json& study, const Provenance& provenance) {
  Json json = json_document("ceilings", study);
  json["status"] = ceilings.reason.empty() ? "found" : "no_solution";
  json["reason"] = ceilings.reason.empty() ? Json(nullptr) : Json(ceilings.reason);
  json["theory"] = to_string(ceilings.theory);
  json["plate_scale_rad_per_m"] = json_number(1 / ceilings.focal_length);
  json["f_min_per_m"] = ceilings.f_min;
  json["f_max_per_m"] = ceilings.f_max;
  json["budgets"] = Json::array();
  for (std::size_t k = 0; k < ceilings.budgets.size(); ++k) {
    const Budget& budget = ceilings.budgets[k];
    json["budgets"].push_back({{"name", budget_name(budget)},
                               {"bound", budget.bound},
                               {"limit", json_number(budget.limit)},
                               {"without_roughness", json_number(ceilings.perfect[k])}});
  }
  const auto end_of = [&](Json* one, double rms, std::size_t binding, const std::string& reason) {
    (*one)["binding"] = std::isfinite(rms) ? Json(ceilings.budgets[binding].key) : Json(nullptr);
    if (!std::isfinite(rms)) (*one)["reason"] = reason;
  };
  json["octaves"] = Json::array();
  for (const OctaveCeiling& octave : ceilings.octaves) {
    Json one{{"frequency_per_m", octave.frequency},
             {"cycles_across", octave.frequency * ceilings.across},
             {"rms_m", json_number(octave.rms)},
             {"profile_psd_m3", json_number(octave.profile_psd)}};
    end_of(&one, octave.rms, octave.binding, octave.reason);
    json["octaves"].push_back(one);
  }
  json["lines"] = Json::array();
  for (const LineCeiling& line : ceilings.lines) {
    // As a power law of a study takes it.
    Json one{{"profile_psd", {{"A", json_number(line.level)}, {"f_unit", "1/mm"}, {"B", line.exponent}}},
             {"rms_m", json_number(line.rms)},
             {"headroom", json_number(line.headroom)},
             {"closest_per_m", json_number(line.closest)}};
    end_of(&one, line.rms, line.binding, line.reason);
    json["lines"].push_back(one);
  }
  json["evaluations"] = ceilings.evaluations;
  json["seconds"] = json_number(ceilings.seconds);
  json["warnings"] = json_warnings(ceilings.warnings);
  json["provenance"] = to_json(provenance);
  return json;
}

std::string summary_table(const Ceilings& ceilings) {
  const bool found = ceilings.reason.empty();
  std::string text = found ? "CEILINGS: " + range_text(ceilings.octaves) + " in one octave alone, " +
                                 range_text(ceilings.lines) + " along a line A/f^B"
                           : "NO SOLUTION";
  text = paragraph("", text, 0) + (ceilings.title.empty() ? "" : ceilings.title + "\n") + "\n";
  text += paragraph("Budget", shown_bounds(ceilings));
  text += fmt::format("Theory    {}; plate scale 1/f = {:.5g} arcsec/mm\n", to_string(ceilings.theory),
                      1e-3 / ceilings.focal_length / unit_factor("arcsec", Dimension::kAngle));
  text += fmt::format("Band      {:.4g} /mm to {:.4g} /mm, {:.4g} to {:.4g} cycles across\n",
                      ceilings.f_min / kPerMillimetre, ceilings.f_max / kPerMillimetre,
                      ceilings.f_min * ceilings.across, ceilings.f_max * ceilings.across);
  text += fmt::format("Cost      {} evaluations, {:.2g} s\n", ceilings.evaluations, ceilings.seconds);
  if (!found) return text + "\n" + paragraph("Why   ", ceilings.reason) + warning_lines(ceilings.warnings);
  text += "\n" +
          paragraph("",
                    "The most in one octave if there were no roughness in any other, as RMS height and as "
                    "a level of one-sided profile PSD over it. Two of these cannot be reached together.",
                    0) +
          octave_rows(ceilings);
  text += "\n" +
          paragraph("",
                    "The largest profile PSD A/f^B, f in 1/mm, over the whole band with nothing beside it "
                    "(the form of ISO 10110-8). All of it may be used up. Headroom: what its nearest "
                    "octave would have for itself, over what the line gives it.",
                    0) +
          line_rows(ceilings);
  return text + warning_lines(ceilings.warnings);
}

std::string ceilings_csv(const Ceilings& ceilings) {
  std::string text = "frequency_per_m,rms_m,profile_psd_m3,binding\n";
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{:.12g}", value) : ""; };
  for (const OctaveCeiling& octave : ceilings.octaves)
    fmt::format_to(std::back_inserter(text), "{:.12g},{},{},{}\n", octave.frequency, number(octave.rms),
                   number(octave.profile_psd),
                   std::isfinite(octave.rms) ? ceilings.budgets[octave.binding].key : "");
  return text;
}

std::vector<std::string> write_ceilings_plots(const Ceilings& ceilings, const std::string& directory,
                                              Warnings* warnings) {
  std::vector<double> at, level;
  for (const OctaveCeiling& octave : ceilings.octaves) {
    if (!std::isfinite(octave.rms)) continue;
    at.push_back(octave.frequency / kPerMillimetre);
    level.push_back(octave.profile_psd / kSquareNanometreMillimetre);
  }
  if (at.empty() || !ceilings.reason.empty()) return {};
  const auto column = [](const std::vector<double>& values) -> Eigen::ArrayXd {
    return Eigen::Map<const Eigen::ArrayXd>(values.data(), Eigen::Index(values.size()));
  };
  Picture picture{"ceilings", script_head("ceilings", 1000, 750), {}};
  picture.add_columns("ceilings.dat",
                      {"The most in one octave alone: its middle [1/mm], level of profile PSD [nm^2 mm]"},
                      {column(at), column(level)});
  picture.script += fmt::format(
      "set title {}\nset logscale xy\nset xrange [{:.9g}:{:.9g}]\nset xlabel 'frequency [1/mm]'\n"
      "set ylabel 'one-sided profile PSD [nm^2 mm]' noenhanced\nset format xy '%g'\nset key left "
      "bottom\n"
      "plot 'ceilings.dat' with linespoints linecolor rgb '#404040' linewidth 2 pointtype 7 title 'one "
      "octave "
      "alone'",
      picture_title(shown_bounds(ceilings), ceilings.title), ceilings.f_min / kPerMillimetre,
      ceilings.f_max / kPerMillimetre);
  constexpr const char* kColours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};
  std::size_t drawn = 0;
  for (const LineCeiling& line : ceilings.lines) {
    if (!std::isfinite(line.rms)) continue;
    picture.script += fmt::format(
        ", \\\n  {:.9g}*x**({:.9g}) with lines linecolor rgb '{}' "
        "linewidth 2 dashtype {} title {}",
        line.level / kSquareNanometreMillimetre, -line.exponent, kColours[drawn % std::size(kColours)],
        1 + drawn / std::size(kColours),
        gnuplot_text(fmt::format("A/f^{:g}, {} RMS", line.exponent, metres_text(line.rms))));
    ++drawn;
  }
  picture.script += "\n";
  return draw_pictures({picture}, directory, warnings);
}

}  // namespace aberfit
