#include "wide_scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "aberfit/study/read_study.h"
#include "sweep/scene_parts.h"

namespace aberfit {
namespace {

constexpr double kLargestSine = 0.15;  // of scatter; the scalar theory warns from 10 degrees on

nlohmann::json aperture_of(const std::string& shape, double across, Dice* dice) {
  if (shape == "rectangle") return rectangle(across, dice->uniform(0.5, 1.0));
  if (shape == "polygon") return hexagon(across);
  nlohmann::json aperture{{"shape", shape}, {"diameter", across}};
  if (shape == "annulus") aperture["inner_diameter"] = across * dice->uniform(0.1, 0.5);
  return aperture;
}

nlohmann::json psd_of(const std::string& family, const Band& band, double across, double rms, Dice* dice) {
  nlohmann::json psd{{"model", family}};
  if (family == "table") {
    psd["file"] = kWideTable;
    return psd;
  }
  psd["rms"] = rms;
  if (family == "gaussian") {
    psd["correlation_length"] = 2 / (std::numbers::pi * band.high);
    return psd;
  }
  psd["f_min"] = band.low;
  psd["f_max"] = band.high;
  if (family == "k-correlation") psd["B"] = across / dice->log_uniform(2, 50);
  if (family != "uniform") psd["exponent"] = dice->uniform(2.2, 3.8);
  return psd;
}

}  // namespace

WideScene wide_scene(int k) {
  constexpr const char* kFamilies[] = {"k-correlation", "power-law", "uniform", "gaussian", "table"};
  constexpr const char* kShapes[] = {"circle", "annulus", "circle", "rectangle", "annulus", "polygon"};
  Dice dice(1400 + std::uint64_t(k));
  const std::string family = kFamilies[k % 5], shape = kShapes[k / 5 % 6];
  const double across = dice.log_uniform(5e-3, 10), f_number = dice.log_uniform(1.5, 40),
               wavelength = dice.log_uniform(13.5e-9, 10.6e-6);
  // A flat spectrum has most of its height at high frequency. Above g = 1 it leaves only a halo.
  const bool flat = family == "uniform" || family == "gaussian";
  const double g = dice.log_uniform(0.1, flat ? 1 : 2);
  WideScene scene;
  scene.cycles = std::min(dice.log_uniform(100, 3000), kLargestSine * across / wavelength);
  const Band band{dice.uniform(0.5, 2) / across, scene.cycles / across};
  const double rms = g * wavelength / (4 * std::numbers::pi);
  const nlohmann::json study{{"aberfit", 1},
                             {"mirror", {{"focal_length", f_number * across}}},
                             {"aperture", aperture_of(shape, across, &dice)},
                             {"light", {{"wavelength", wavelength}}},
                             {"roughness", {{"psd", psd_of(family, band, across, rms, &dice)}}},
                             {"output", {{"pictures", "none"}}}};
  scene.study = study.dump();
  if (family == "table") scene.table = shouldered_table(band, rms, &dice);
  scene.name = fmt::format("{} {}, {:.2g} m f/{:.2g}, {:.3g} um, g {:.2g}, {:.0f} cycles", family, shape,
                           across, f_number, 1e6 * wavelength, g, scene.cycles);
  return scene;
}

Study study_of(const WideScene& scene, const std::filesystem::path& folder) {
  if (!scene.table.empty()) std::ofstream(folder / kWideTable) << scene.table;
  return parse_study(scene.study, (folder / "scene.json").string());
}

}  // namespace aberfit
