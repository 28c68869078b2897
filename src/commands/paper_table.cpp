#include "paper_table.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "aberfit/core/units.h"
#include "aberfit/method/physics_choice.h"
#include "aberfit/theory/model_choice.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;

ordered_json number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

std::string length(double metres) { return format_quantity(metres, Dimension::kLength); }

}  // namespace

std::string paper_verdict(double ratio) {
  return ratio >= kPaperRatioForRays ? "rays" : ratio < 1 ? "waves" : "unclear";
}

ordered_json paper_table(const PaperTable& ranges, double focal_length, std::string* table) {
  const Mirror mirror{focal_length, -1, {}};
  ordered_json rows = ordered_json::array();
  std::string text = fmt::format(
      "R = 2 sigma D/(1.22 lambda l_c) at {}: the paper takes rays where R >> 1 (here: from {:.0f} up)\n\n"
      "  {:>10} {:>10} {:>10} {:>11} {:>9} {:>10} {:>10} {:>8} {:>10}\n",
      length(ranges.wavelength), kPaperRatioForRays, "sigma", "l_c", "D", "R", "g", "kappa", "ray ee90*",
      "paper", "ours");
  for (const double diameter : ranges.diameters) {
    for (const double sigma : ranges.rms_heights) {
      for (const double l_c : ranges.correlation_lengths) {
        // int exp(-(r/l)^2) dr = sqrt(pi)/2 l
        const RadialPsd psd(GaussianPsd{sigma, 2 * l_c / std::sqrt(std::numbers::pi)});
        const Aperture aperture = CircleAperture{diameter};
        const SceneNumbers n = scene_numbers(psd, mirror, aperture, ranges.wavelength);
        const ModelChoice choice = choose_model(psd, mirror, aperture, ranges.wavelength);
        const std::string ours = to_string(choice.model);
        const double error = choice.errors.ray_ee90;
        text += fmt::format("  {:>10} {:>10} {:>10} {:>11.4g} {:>9.3g} {:>10.3g} {:>10} {:>8} {:>10}\n",
                            length(sigma), length(l_c), length(diameter), n.paper_ratio_r, n.g, n.kappa,
                            std::isfinite(error) ? fmt::format("{:+.3g} %", 100 * error) : "-",
                            paper_verdict(n.paper_ratio_r), ours);
        rows.push_back({{"rms_height_m", sigma},
                        {"correlation_length_m", l_c},
                        {"diameter_m", diameter},
                        {"paper_ratio_r", number(n.paper_ratio_r)},
                        {"g", number(n.g)},
                        {"kappa", number(n.kappa)},
                        {"ray_ee90_error", number(error)},
                        {"paper_verdict", paper_verdict(n.paper_ratio_r)},
                        {"needed", ours}});
      }
    }
  }
  text += "\n  * error of the ray ee90 against generalised Harvey-Shack; Gaussian autocorrelation\n";
  if (table) *table += text;
  return {{"wavelength_m", ranges.wavelength}, {"rows", rows}};
}

}  // namespace aberfit
