#include "scene_parts.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numbers>

namespace aberfit {

nlohmann::json hexagon(double across) {
  nlohmann::json corners;
  for (int corner = 0; corner < 6; ++corner)
    corners.push_back({0.5 * across * std::cos(corner * std::numbers::pi / 3),
                       0.5 * across * std::sin(corner * std::numbers::pi / 3)});
  return {{"shape", "polygon"}, {"vertices", corners}};
}

nlohmann::json rectangle(double across, double angle) {
  return {{"shape", "rectangle"}, {"width", across * std::cos(angle)}, {"height", across * std::sin(angle)}};
}

std::string shouldered_table(const Band& band, double rms, Dice* dice) {
  constexpr int kPoints = 40;
  const double exponent = dice->uniform(2.2, 3.2), shoulder = dice->log_uniform(0.5, 5),
               at = dice->log_uniform(2 * band.low, 0.5 * band.high);
  const auto shape = [&](double f) {
    const double decades = std::log10(f / at);
    return std::pow(f / band.low, -exponent) * (1 + shoulder * std::exp(-8 * decades * decades));
  };
  const double ratio = std::pow(band.high / band.low, 1.0 / (kPoints - 1));
  double variance = 0;
  for (int i = 0; i + 1 < kPoints; ++i) {
    const double f = band.low * std::pow(ratio, i), g = f * ratio;
    variance += std::numbers::pi * std::log(ratio) * (f * f * shape(f) + g * g * shape(g));
  }
  std::string text = "f_per_m psd_m4\n";
  for (int i = 0; i < kPoints; ++i) {
    const double f = band.low * std::pow(ratio, i);
    text += fmt::format("{:.9e} {:.9e}\n", f, rms * rms / variance * shape(f));
  }
  return text;
}

}  // namespace aberfit
