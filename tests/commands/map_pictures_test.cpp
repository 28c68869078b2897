// Output of `fit` for a map: panels and PSF with the same numbers in JSON, table and pictures; pictures by
// rays only if rays are a valid model.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "aberfit/core/constants.h"
#include "aberfit/measured/write_map.h"
#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr double kPitch = 1e-3, kRim = 25e-3;

// Defocus of `rms`, a ripple that four orders cannot carry, a tilt of the mount, and a hole of three points.
HeightMap part(double rms) {
  HeightMap map;
  map.pitch_x = map.pitch_y = kPitch;
  map.height = Grid::Constant(51, 51, kNaN);
  centre_on_grid(&map);
  for (Eigen::Index row = 0; row < map.rows(); ++row)
    for (Eigen::Index column = 0; column < map.columns(); ++column) {
      const double x = map.x(column), y = map.y(row), rho = std::hypot(x, y) / kRim;
      if (rho > 1 + 1e-9) continue;
      map.height(row, column) = rms * std::sqrt(3.0) * (2 * rho * rho - 1) +
                                4e-9 * std::sin(1500 * x) * std::cos(900 * y) + 1e-6 * x / kRim;
    }
  for (const Eigen::Index column : {30, 31, 32}) map.height(20, column) = kNaN;
  return map;
}

// Numbers of a data file, including "nan".
std::vector<std::vector<double>> numbers(const std::string& path) {
  std::ifstream in(path);
  EXPECT_TRUE(in) << path;
  std::vector<std::vector<double>> all;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("#")) continue;
    std::istringstream cells(line);
    std::vector<double> row;
    for (std::string cell; cells >> cell;) row.push_back(std::strtod(cell.c_str(), nullptr));
    all.push_back(row);
  }
  return all;
}

struct MapRun {
  ScratchFolder folder;
  ordered_json result;
  std::string summary;

  explicit MapRun(double rms, const std::string& trace = "") {
    folder.write("map.csv", map_csv(part(rms)));
    folder.write("study.json", R"({"aberfit": 1, "mirror": {"focal_length": "1 m"},
        "light": {"wavelength": "632.8 nm"}, "aperture": {"shape": "circle", "diameter": "50 mm"},
        "target": {"map": {"file": "map.csv", "origin": "file"}}, "terms": {"zernike": {"n_max": 4}},
        "trace": {"rays": 4096)" + trace +
                                   "}}");
    EXPECT_EQ(run_program(folder, "fit study.json --json -o out"), 0) << read_file(folder.file("stderr.txt"));
    result = ordered_json::parse(read_file(folder.file("stdout.txt")));
    summary = read_file(folder.file("out/summary.txt"));
  }
  std::string plot(const std::string& name) const { return folder.file("out/plots/" + name); }
  bool drawn(const std::string& name) const { return fs::exists(plot(name + ".gp")); }
  bool warned(const std::string& code) const {
    for (const auto& warning : result["warnings"])
      if (warning["code"] == code) return true;
    return false;
  }
};

const MapRun& small_errors() {
  static const MapRun run(20e-9);
  return run;
}

const std::vector<std::string> kOfRays = {"ee_curves", "ring_through", "focal_images"};

TEST(MapPictures, AgreeWithResultAndTable) {
  const MapRun& run = small_errors();
  const ordered_json& light = run.result["map"]["light"];
  const auto curves = numbers(run.plot("map_light.dat"));
  const std::string script = read_file(run.plot("map_light.values"));
  const char* const columns[] = {"measured", "terms", "terms_and_residual_psd", "perfect"};
  for (std::size_t c = 0; c < 4; ++c) {
    const ordered_json& column = light[columns[c]];
    const double strehl = column["strehl"], ee80 = column["ee80_radius_m"], fwhm = column["spot_fwhm_m"];
    EXPECT_NE(run.summary.find(fmt::format("{:#.4g}", strehl)), std::string::npos) << columns[c];
    EXPECT_NE(run.summary.find(fmt::format("{:#.4g} um", 1e6 * ee80)), std::string::npos) << columns[c];
    EXPECT_NE(run.summary.find(fmt::format("{:#.4g} um", 1e6 * fwhm)), std::string::npos) << columns[c];
    EXPECT_NE(script.find(fmt::format("ee80 {:.4g} µm", 1e6 * ee80)), std::string::npos) << columns[c];
    std::size_t k = 0;  // first radius with 80 % of the light
    while (curves[k][c + 1] < 0.8) ++k;
    const double low = curves[k - 1][c + 1], high = curves[k][c + 1];
    const double at = curves[k - 1][0] + (0.8 - low) / (high - low) * (curves[k][0] - curves[k - 1][0]);
    EXPECT_NEAR(at / ee80, 1, 2e-3) << columns[c];  // a chord of the curve
    if (c == 3) continue;
    EXPECT_NE(script.find(fmt::format("Strehl {:.4f}", strehl)), std::string::npos) << columns[c];
    double highest = 0;
    for (const auto& row : numbers(run.plot(fmt::format("map_light_{}.dat", columns[c]))))
      for (const double value : row) highest = std::max(highest, value);
    EXPECT_NEAR(highest / strehl, 1, 0.03) << columns[c];  // samples a quarter of wavelength f/D apart
  }
  EXPECT_GT(light["measured"]["ee80_radius_m"].get<double>(),
            light["perfect"]["ee80_radius_m"].get<double>());
  EXPECT_NEAR(light["filled_share"].get<double>(), 3 * kPitch * kPitch / (kPi * kRim * kRim), 1e-4);
  // The statistics of the terms come from the same PSF.
  EXPECT_EQ(run.result["statistics"]["fitted"]["ee80_radius_m"], light["terms"]["ee80_radius_m"]);
}

TEST(MapPictures, ShowTheMapItsTermsAndTheRest) {
  const MapRun& run = small_errors();
  const ordered_json& heights = run.result["map"]["heights"];
  const std::string script = read_file(run.plot("map_heights.values"));
  const auto measured = numbers(run.plot("map_heights_measured.dat")),
             fitted = numbers(run.plot("map_heights_fitted.dat")),
             residual = numbers(run.plot("map_heights_residual.dat"));
  const auto panel = [&](const char* key, const std::vector<std::vector<double>>& rows) {
    double sum = 0, squares = 0, low = HUGE_VAL, high = -HUGE_VAL, count = 0;
    for (const auto& row : rows)
      for (const double h : row)
        if (std::isfinite(h))
          sum += h, squares += h * h, ++count, low = std::min(low, h), high = std::max(high, h);
    const double rms = heights[key]["rms_m"], peak_to_valley = heights[key]["peak_to_valley_m"];
    EXPECT_NEAR(std::sqrt(squares / count - std::pow(sum / count, 2)) / rms, 1, 1e-4) << key;
    EXPECT_NEAR((high - low) / peak_to_valley, 1, 1e-4) << key;
    EXPECT_NE(script.find(fmt::format("RMS {:.4g} nm, PV {:.4g} nm", 1e9 * rms, 1e9 * peak_to_valley)),
              std::string::npos)
        << key;
  };
  panel("measured", measured), panel("fitted", fitted), panel("residual", residual);
  const HeightMap map = part(20e-9);
  int valid = 0;
  for (std::size_t row = 0; row < measured.size(); ++row)
    for (std::size_t column = 0; column < measured[row].size(); ++column) {
      const bool there = std::isfinite(measured[row][column]);
      valid += there;
      EXPECT_EQ(there, std::isfinite(fitted[row][column]));
      if (there) {
        EXPECT_NEAR(fitted[row][column] + residual[row][column], measured[row][column], 1e-12);
      }
    }
  EXPECT_EQ(valid, valid_count(map));  // rim and hole are blank
  // The tilt of a micrometre comes from the mount, the defocus from the part.
  EXPECT_NEAR(heights["measured"]["rms_m"].get<double>(), std::hypot(20e-9, 2e-9), 0.3e-9);
}

TEST(MapPictures, LeaveOutRaysWhereTheyAreNoModel) {
  const MapRun& run = small_errors();
  EXPECT_EQ(run.result["statistics"]["fitted"].size(), 6u);
  EXPECT_NE(run.summary.find("at the focus, by waves"), std::string::npos);
  EXPECT_FALSE(run.warned("rays-not-valid"));
  for (const std::string& name : kOfRays) EXPECT_FALSE(run.drawn(name)) << name;
  for (const char* name : {"map_heights", "map_light", "surface", "gradients"})
    EXPECT_TRUE(run.drawn(name)) << name;
}

TEST(MapPictures, ShowRaysWhereTheyAreAModelOrAskedFor) {
  const MapRun large(400e-9), asked(20e-9, R"(, "model": "rays")"), waves(400e-9, R"(, "model": "waves")");
  for (const std::string& name : kOfRays) {
    EXPECT_TRUE(large.drawn(name)) << name;
    EXPECT_TRUE(asked.drawn(name)) << name;
    EXPECT_FALSE(waves.drawn(name)) << name;
  }
  EXPECT_FALSE(large.warned("rays-not-valid"));
  EXPECT_TRUE(asked.warned("rays-not-valid"));
  EXPECT_NE(large.summary.find("at the focus, by rays"), std::string::npos);
  // For a large defocus both models give the same radius except for diffraction.
  const auto ee80 = [](const MapRun& run) {
    return run.result["statistics"]["fitted"]["ee80_radius_m"].get<double>();
  };
  EXPECT_NEAR(ee80(waves) / ee80(large), 1, 0.05);
  EXPECT_EQ(ee80(waves), large.result["map"]["light"]["terms"]["ee80_radius_m"].get<double>());
}

TEST(MapPictures, RefuseWavesThatThePointsDoNotHold) {
  ScratchFolder folder;
  const auto run = [&](const std::string& model) {
    folder.write("map.csv", map_csv(part(50e-6)));
    folder.write("study.json", R"({"aberfit": 1, "mirror": {"focal_length": "1 m"},
        "light": {"wavelength": "632.8 nm"}, "aperture": {"shape": "circle", "diameter": "50 mm"},
        "target": {"map": {"file": "map.csv", "origin": "file"}}, "terms": {"zernike": {"n_max": 4}},
        "output": {"pictures": "none"}, "trace": {"rays": 4096, "model": ")" +
                                   model + R"("}})");
    return run_program(folder, "fit study.json -o out");
  };
  EXPECT_EQ(run("waves"), 2);
  EXPECT_NE(read_file(folder.file("stderr.txt")).find("/trace/model"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder.file("out/result.json")));
  EXPECT_EQ(run("auto"), 0);
  const std::string summary = read_file(folder.file("out/summary.txt"));
  EXPECT_NE(summary.find("measured map: no PSF, the surface is too steep"), std::string::npos) << summary;
}

}  // namespace
}  // namespace aberfit::test
