#include "random_scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "sweep/scene_parts.h"

namespace aberfit {
namespace {

using nlohmann::json;

constexpr double kPi = std::numbers::pi;
constexpr double kLargestSine = 0.15;  // of scatter; the scalar theory warns from 10 degrees on
constexpr const char* kFamilies[] = {"k-correlation", "power-law", "uniform", "gaussian", "table", "sum"};
constexpr const char* kShapes[] = {"circle", "annulus", "circle", "rectangle", "polygon"};
// Any stretch of rows has the kinds in nearly these fractions.
constexpr const char* kKinds[] = {"open", "open",    "zernike",   "open",   "geometric",
                                  "open", "open",    "conic",     "open",   "planes",
                                  "open", "open",    "fourier",   "open",   "spherical",
                                  "open", "open",    "geometric", "open",   "known zernikes",
                                  "open", "zernike", "open",      "planes", "grazing"};

// The numbers of a scene, before they become a study.
struct Draw {
  std::string kind, family, shape;
  double across, f_number, wavelength;  // lengths [m]
  double g, cycles;
  double lowest;  // of the band, cycles across
  Band band() const { return {lowest / across, cycles / across}; }
  double rms() const { return g * wavelength / (4 * kPi); }
  bool flat() const { return family == "uniform" || family == "gaussian"; }
};

double widest_of(const std::string& kind) {
  // Terms of these kinds reach every frequency of the band.
  if (kind == "zernike" || kind == "spherical") return 20;
  if (kind == "fourier" || kind == "geometric") return 100;
  return 3000;
}

// Keeps band and height so low that the scatter stays within kLargestSine. For a flat spectrum the deflection
// is g times that of its highest frequency. In other spectra high frequencies have little height.
void keep_in_theory(Draw* draw) {
  const double fine = kLargestSine * draw->across / draw->wavelength, share = draw->flat() ? 1 : 0.2;
  draw->g = std::min(draw->g, std::max(0.02, fine / (4 * share)));
  draw->cycles = std::clamp(draw->cycles, 3.0, std::max(3.0, fine / std::max(1.0, share * draw->g)));
}

Draw draw_numbers(int k, Dice* dice) {
  Draw draw;
  draw.kind = kKinds[std::size_t(k) % std::size(kKinds)];
  draw.family = kFamilies[std::size_t(k) % std::size(kFamilies)];
  draw.shape = kShapes[std::size_t(dice->whole(0, int(std::size(kShapes)) - 1))];
  draw.across = dice->log_uniform(5e-3, 10);
  draw.f_number = dice->log_uniform(1, 40);
  draw.wavelength = dice->log_uniform(13.5e-9, 10.6e-6);
  draw.g = dice->log_uniform(0.02, 50);
  draw.cycles = dice->log_uniform(3, widest_of(draw.kind));
  draw.lowest = dice->uniform(0.3, 2);
  if (draw.kind != "grazing") keep_in_theory(&draw);
  return draw;
}

// The corners are in order of their angle about the middle, so that no edges cross. The middle is up to two
// radii from the axis, as for segments of a large mirror.
json polygon(double across, Dice* dice) {
  const int corners = dice->whole(3, 9);
  const double away = dice->uniform(0, 1) < 0.6 ? 0 : dice->uniform(0, 1) * across;
  const double where = dice->uniform(0, 2 * kPi), turn = dice->uniform(0, 2 * kPi);
  json vertices;
  for (int corner = 0; corner < corners; ++corner) {
    const double angle = turn + 2 * kPi * (corner + dice->uniform(-0.3, 0.3)) / corners,
                 reach = 0.5 * across * dice->uniform(0.6, 1);
    vertices.push_back(
        {away * std::cos(where) + reach * std::cos(angle), away * std::sin(where) + reach * std::sin(angle)});
  }
  return {{"shape", "polygon"}, {"vertices", vertices}};
}

json aperture_of(const Draw& draw, Dice* dice) {
  if (draw.shape == "rectangle") return rectangle(draw.across, dice->uniform(0.15, 1.4));
  if (draw.shape == "polygon") return polygon(draw.across, dice);
  json aperture{{"shape", draw.shape}, {"diameter", draw.across}};
  if (draw.shape == "annulus") aperture["inner_diameter"] = draw.across * dice->uniform(0.05, 0.9);
  return aperture;
}

json one_psd(const std::string& family, const Band& band, double across, double rms, Dice* dice) {
  json psd{{"model", family}, {"rms", rms}};
  if (family == "gaussian") {
    psd["correlation_length"] = 2 / (kPi * band.high);
    return psd;
  }
  if (family == "k-correlation") {
    psd["B"] = across / dice->log_uniform(2, 50);
    psd["exponent"] = dice->uniform(2.2, 3.8);
    if (dice->uniform(0, 1) < 0.15) {  // the slopes of a spectrum without an end need a steeper one
      psd["B"] = 1 / band.high;
      psd["exponent"] = dice->uniform(4.3, 6);
      return psd;
    }
  }
  if (family == "power-law") psd["exponent"] = dice->uniform(1, 4.5);
  psd["f_min"] = band.low;
  psd["f_max"] = band.high;
  return psd;
}

json psd_of(const Draw& draw, Dice* dice) {
  if (draw.family == "table") return {{"model", "table"}, {"file", kRandomTable}};
  if (draw.family != "sum") return one_psd(draw.family, draw.band(), draw.across, draw.rms(), dice);
  // Figure and finish: most of the height at low, a smaller part at high frequency.
  const double share = dice->uniform(0.1, 0.9);
  const Band whole = draw.band();
  const Band coarse{whole.low, whole.low + dice->uniform(0.2, 1) * (whole.high - whole.low)};
  json parts;
  parts.push_back(one_psd("power-law", coarse, draw.across, std::sqrt(1 - share) * draw.rms(), dice));
  parts.push_back(one_psd(dice->uniform(0, 1) < 0.5 ? "gaussian" : "k-correlation", whole, draw.across,
                          std::sqrt(share) * draw.rms(), dice));
  return {{"model", "sum"}, {"parts", parts}};
}

// A conic within a few waves of the parabola, so that it has a useful focus; now and then a sphere.
double conic_of(const Draw& draw, Dice* dice) {
  if (dice->uniform(0, 1) < 0.3) return 0;
  const double focal_length = draw.f_number * draw.across, r = 0.5 * draw.across;
  const double sag = std::pow(r, 4) / (64 * std::pow(focal_length, 3));  // of one unit of the constant
  const double conic = dice->log_uniform(0.05, 10) * draw.wavelength / (2 * sag);
  return -1 + (dice->uniform(0, 1) < 0.5 ? -1 : 1) * std::min(conic, 2.0);
}

json named_statistics(const Draw& draw, Dice* dice) {
  const double depth = 2 * draw.wavelength * draw.f_number * draw.f_number * std::max(1.0, draw.g);
  const double airy = draw.wavelength * draw.f_number;
  json statistics;
  statistics["ee50"] = {{"planes", {0.0, depth * dice->uniform(-3, 3), depth * dice->uniform(-3, 3)}}};
  statistics["ee80"] = json::object();
  if (dice->uniform(0, 1) < 0.5) statistics["ee90"] = {{"planes", {depth * dice->uniform(-1, 1)}}};
  if (dice->uniform(0, 1) < 0.4) statistics["ring_fwhm"] = json::object();
  if (dice->uniform(0, 1) < 0.4)
    statistics["ee_within"] = {{"radii", {airy * dice->log_uniform(1, 10 * std::max(1.0, draw.g))}}};
  if (dice->uniform(0, 1) < 0.3) statistics["rms_height"] = json::object();
  if (dice->uniform(0, 1) < 0.3) statistics["spot_fwhm"] = json::object();
  return statistics;
}

void ask_of_kind(const Draw& draw, json* study, Dice* dice) {
  const json order{{"n_max", int(std::lround(dice->log_uniform(6, 70)))}};
  if (draw.kind == "zernike") (*study)["terms"] = {{"zernike", order}};
  if (draw.kind == "fourier") {
    const int count = int(std::lround(dice->log_uniform(50, 1000)));
    (*study)["terms"]["fourier"] =
        dice->uniform(0, 1) < 0.5 ? json{{"count", count}} : json{{"sampling", "grid"}};
  }
  if (draw.kind == "spherical") {
    (*study)["terms"]["spherical"] = {"c4", "c6", "c8"};
    (*study)["terms"]["zernike"] = order;
    (*study)["fit"]["spherical_rms"] = draw.rms();
  }
  if (draw.kind == "geometric") (*study)["target"]["theory"] = "geometric";
  if (draw.kind == "planes") (*study)["target"]["statistics"] = named_statistics(draw, dice);
  if (draw.kind == "conic") (*study)["mirror"]["conic"] = conic_of(draw, dice);
  if (draw.kind == "known zernikes")
    (*study)["mirror"]["zernike"]["noll"] = {{"4", draw.wavelength * dice->uniform(-0.2, 0.2)},
                                             {"7", draw.wavelength * dice->uniform(-0.2, 0.2)},
                                             {"11", draw.wavelength * dice->uniform(-0.1, 0.1)}};
}

std::string between(double value, const std::vector<double>& edges, const char* unit) {
  std::size_t at = 0;
  while (at < edges.size() && value >= edges[at]) ++at;
  if (at == 0) return fmt::format("below {:g}{}", edges.front(), unit);
  if (at == edges.size()) return fmt::format("from {:g}{}", edges.back(), unit);
  return fmt::format("{:g} to {:g}{}", edges[at - 1], edges[at], unit);
}

}  // namespace

RandomScene random_scene(std::uint64_t seed, int k) {
  Dice dice(seed * 1000003 + std::uint64_t(k));
  const Draw draw = draw_numbers(k, &dice);
  RandomScene scene;
  json study{{"aberfit", 1},
             {"mirror", {{"focal_length", draw.f_number * draw.across}}},
             {"aperture", aperture_of(draw, &dice)},
             {"light", {{"wavelength", draw.wavelength}}},
             {"output", {{"pictures", "none"}}}};
  study["roughness"]["psd"] = psd_of(draw, &dice);
  if (draw.family == "table") scene.table = shouldered_table(draw.band(), draw.rms(), &dice);
  ask_of_kind(draw, &study, &dice);
  scene.study = study.dump();
  scene.all_open = draw.kind == "open" || draw.kind == "conic" || draw.kind == "known zernikes";
  scene.classes = {{"kind", draw.kind},
                   {"psd", draw.family},
                   {"aperture", draw.shape},
                   {"g", between(draw.g, {0.1, 1, 5}, "")},
                   {"cycles", between(draw.cycles, {20, 200}, "")},
                   {"light", between(1e6 * draw.wavelength, {0.1, 1.5}, " um")},
                   {"f-number", between(draw.f_number, {2, 8}, "")}};
  scene.name =
      fmt::format("{} {} {}, {:.2g} m f/{:.2g}, {:.3g} um, g {:.2g}, {:.0f} cycles", draw.kind, draw.family,
                  draw.shape, draw.across, draw.f_number, 1e6 * draw.wavelength, draw.g, draw.cycles);
  return scene;
}

}  // namespace aberfit
