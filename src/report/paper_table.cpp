#include "paper_table.h"

#include <fmt/format.h>

#include <cmath>

#include "aberfit/core/units.h"
#include "json_number.h"
#include "paragraph.h"

namespace aberfit::internal {
namespace {

std::string needed_word(const PaperCell& cell) { return to_string(cell.needed); }

}  // namespace

Json to_json(const PaperCells& table) {
  Json rows = Json::array();
  for (const PaperCell& cell : table.cells)
    rows.push_back({{"rms_height_m", cell.rms_height},
                    {"correlation_length_m", cell.correlation_length},
                    {"diameter_m", cell.diameter},
                    {"paper_ratio_r", json_number(cell.ratio)},
                    {"g", json_number(cell.g)},
                    {"kappa", json_number(cell.kappa)},
                    {"ray_ee90_error", json_number(cell.ray_ee90_error)},
                    {"share_beyond_10_degrees", json_number(cell.wide_share)},
                    {"paper_verdict", paper_verdict(cell.ratio)},
                    {"needed", needed_word(cell)}});
  return {{"wavelength_m", table.wavelength}, {"rows", rows}};
}

std::string summary_table(const PaperCells& table) {
  std::string text = fmt::format(
      "R = 2 sigma D/(1.22 lambda l_c) at {}: the paper takes rays where R >> 1 (here: from {:.0f} up)\n\n"
      "  {:>10} {:>10} {:>10} {:>11} {:>9} {:>10} {:>10} {:>8} {:>10}\n",
      metres_text(table.wavelength), kPaperRatioForRays, "sigma", "l_c", "D", "R", "g", "kappa", "ray ee90*",
      "paper", "ours");
  int wide = 0;
  for (const PaperCell& cell : table.cells) {
    const bool is_wide = cell.wide_share > kWideShare;
    wide += int(is_wide);
    const double error = cell.ray_ee90_error;
    text += fmt::format("  {:>10} {:>10} {:>10} {:>11.4g} {:>9.3g} {:>10.3g} {:>10} {:>8} {:>10}{}\n",
                        metres_text(cell.rms_height), metres_text(cell.correlation_length),
                        metres_text(cell.diameter), cell.ratio, cell.g, cell.kappa,
                        std::isfinite(error) ? fmt::format("{:+.3g} %", 100 * error) : "-",
                        paper_verdict(cell.ratio), needed_word(cell), is_wide ? " !" : "");
  }
  text += "\n  * error of the ray ee90 against generalised Harvey-Shack; Gaussian autocorrelation\n";
  if (wide > 0)
    text += fmt::format(
        "  ! warning: {}\n",
        wrapped(
            fmt::format("more than {:.1f} % of the light is scattered beyond 10 degrees in these {} cells: "
                        "rays and Harvey-Shack, both theories of small angles, say less about them",
                        100 * kWideShare, wide),
            kColumns - 4, 4));
  return text;
}

}  // namespace aberfit::internal
