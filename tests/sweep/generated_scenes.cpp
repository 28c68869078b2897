#include "generated_scenes.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "scene_parts.h"

namespace aberfit {

GeneratedScene generated_scene(int k) {
  Dice dice(1300 + std::uint64_t(k));
  constexpr double kWavelength = 632.8e-9;
  const double g = dice.log_uniform(0.05, 20), f_number = dice.log_uniform(1.5, 20),
               across = dice.log_uniform(0.1, 2);
  const double cycles = dice.log_uniform(4, 60), lowest = dice.uniform(0.5, 2);
  const double rms = g * kWavelength / (4 * std::numbers::pi);

  constexpr const char* kFamilies[] = {"uniform", "k-correlation", "power-law", "gaussian"};
  const std::string family = kFamilies[k % 4];
  nlohmann::json psd{{"model", family}, {"rms", rms}};
  if (family == "gaussian") {
    psd["correlation_length"] = 2 * across / (std::numbers::pi * cycles);
  } else {
    psd["f_min"] = lowest / across;
    psd["f_max"] = cycles / across;
  }
  if (family == "k-correlation") psd["B"] = across / dice.uniform(2, 10);
  if (family == "k-correlation" || family == "power-law") psd["exponent"] = dice.uniform(2.2, 3.8);

  constexpr const char* kShapes[] = {"circle", "annulus", "rectangle", "polygon"};
  const std::string shape = kShapes[k / 4 % 4];
  nlohmann::json aperture{{"shape", shape}};
  if (shape == "circle" || shape == "annulus") aperture["diameter"] = across;
  if (shape == "annulus") aperture["inner_diameter"] = across * dice.uniform(0.1, 0.5);
  if (shape == "rectangle") aperture["width"] = 0.8 * across, aperture["height"] = 0.5 * across;
  if (shape == "polygon") aperture = hexagon(across);
  const nlohmann::json study{{"aberfit", 1},
                             {"mirror", {{"focal_length", f_number * across}}},
                             {"aperture", aperture},
                             {"light", {{"wavelength", kWavelength}}},
                             {"roughness", {{"psd", psd}}},
                             {"output", {{"pictures", "none"}}}};
  return {fmt::format("{} {}, g {:.2g}, f/{:.3g}, {:.2g} m, {:.3g} cycles", family, shape, g, f_number,
                      across, cycles),
          study.dump()};
}

}  // namespace aberfit
