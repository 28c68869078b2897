#include "wide_scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

constexpr double kLargestSine = 0.15;  // of scatter; scalar theory ends at 10 degrees

class Dice {
 public:
  explicit Dice(int k) : bits_(1400 + std::uint64_t(k)) {}
  double uniform(double low, double high) { return low + (high - low) * (double(bits_() >> 11) * 0x1p-53); }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }

 private:
  std::mt19937_64 bits_;
};

struct Band {
  double low = 0, high = 0;  // [cycles/m]
};

nlohmann::json aperture_of(const std::string& shape, double across, Dice* dice) {
  nlohmann::json aperture{{"shape", shape}};
  if (shape == "circle" || shape == "annulus") aperture["diameter"] = across;
  if (shape == "annulus") aperture["inner_diameter"] = across * dice->uniform(0.1, 0.5);
  if (shape == "rectangle") {
    const double angle = dice->uniform(0.5, 1.0);  // of the diagonal
    aperture["width"] = across * std::cos(angle);
    aperture["height"] = across * std::sin(angle);
  }
  if (shape == "polygon")
    for (int corner = 0; corner < 6; ++corner)
      aperture["vertices"].push_back({0.5 * across * std::cos(corner * std::numbers::pi / 3),
                                      0.5 * across * std::sin(corner * std::numbers::pi / 3)});
  return aperture;
}

// A power law with a shoulder, as polishing leaves it: 40 points of frequency and 2-D PSD [m^4].
std::string table_of(const Band& band, double rms, Dice* dice) {
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
  std::string text;
  for (int i = 0; i < kPoints; ++i) {
    const double f = band.low * std::pow(ratio, i);
    text += fmt::format("{:.9e} {:.9e}\n", f, rms * rms / variance * shape(f));
  }
  return text;
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
  Dice dice(k);
  const std::string family = kFamilies[k % 5], shape = kShapes[k / 5 % 6];
  const double across = dice.log_uniform(5e-3, 10), f_number = dice.log_uniform(1.5, 40),
               wavelength = dice.log_uniform(13.5e-9, 10.6e-6);
  // A flat spectrum has all of its height far out: above g = 1 it leaves no focus but a halo.
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
                             {"output", {{"plots", false}}}};
  scene.study = study.dump();
  if (family == "table") scene.table = table_of(band, rms, &dice);
  scene.name = fmt::format("{} {}, {:.2g} m f/{:.2g}, {:.3g} um, g {:.2g}, {:.0f} cycles", family, shape,
                           across, f_number, 1e6 * wavelength, g, scene.cycles);
  return scene;
}

Study study_of(const WideScene& scene, const std::filesystem::path& folder) {
  if (!scene.table.empty()) std::ofstream(folder / kWideTable) << scene.table;
  return parse_study(scene.study, (folder / "scene.json").string());
}

}  // namespace aberfit
