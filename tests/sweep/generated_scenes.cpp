#include "generated_scenes.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

namespace aberfit {

GeneratedScene generated_scene(int k) {
  std::mt19937_64 bits(1300 + std::uint64_t(k));
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (double(bits() >> 11) * 0x1p-53);
  };
  const auto log_uniform = [&](double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  };
  constexpr double kWavelength = 632.8e-9;
  const double g = log_uniform(0.05, 20), f_number = log_uniform(1.5, 20), across = log_uniform(0.1, 2);
  const double cycles = log_uniform(4, 60), lowest = uniform(0.5, 2);
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
  if (family == "k-correlation") psd["B"] = across / uniform(2, 10);
  if (family == "k-correlation" || family == "power-law") psd["exponent"] = uniform(2.2, 3.8);

  constexpr const char* kShapes[] = {"circle", "annulus", "rectangle", "polygon"};
  const std::string shape = kShapes[k / 4 % 4];
  nlohmann::json aperture{{"shape", shape}};
  if (shape == "circle" || shape == "annulus") aperture["diameter"] = across;
  if (shape == "annulus") aperture["inner_diameter"] = across * uniform(0.1, 0.5);
  if (shape == "rectangle") aperture["width"] = 0.8 * across, aperture["height"] = 0.5 * across;
  if (shape == "polygon")
    for (int corner = 0; corner < 6; ++corner)
      aperture["vertices"].push_back({0.5 * across * std::cos(corner * std::numbers::pi / 3),
                                      0.5 * across * std::sin(corner * std::numbers::pi / 3)});
  const nlohmann::json study{{"aberfit", 1},
                             {"mirror", {{"focal_length", f_number * across}}},
                             {"aperture", aperture},
                             {"light", {{"wavelength", kWavelength}}},
                             {"roughness", {{"psd", psd}}},
                             {"output", {{"plots", false}}}};
  return {fmt::format("{} {}, g {:.2g}, f/{:.3g}, {:.2g} m, {:.3g} cycles", family, shape, g, f_number,
                      across, cycles),
          study.dump()};
}

}  // namespace aberfit
