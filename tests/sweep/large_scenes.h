#pragma once
#include <string>
#include <vector>

namespace aberfit {

/// Mirrors with wide bands, and the grids that resolve all of their roughness.
struct LargeScene {
  std::string name, study;
  int cells = 0;   ///< grid points across the aperture, three or more a cycle
  int points = 0;  ///< points of a height map
};
inline const std::vector<LargeScene>& large_scenes() {
  const auto wide = [](const std::string& f_max) {
    return R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"},
               "aperture": {"shape": "circle", "diameter": "0.4 m"}, "light": {"wavelength": "632.8 nm"},
               "roughness": {"psd": {"model": "k-correlation", "rms": "20 nm", "B": "20 mm", "exponent": 3.2,
                                     "f_min": "5 /m", "f_max": ")" +
           f_max + R"( /m"}}})";
  };
  static const std::vector<LargeScene> scenes = {
      {"large-annulus",
       R"({"aberfit": 1, "mirror": {"focal_length": "5.52 m"},
           "aperture": {"shape": "annulus", "diameter": "2.4 m", "inner_diameter": "0.8 m"},
           "light": {"wavelength": "550 nm"},
           "roughness": {"psd": {"model": "k-correlation", "rms": "15 nm", "B": "0.3 m", "exponent": 2.8,
                                 "f_min": "0.8 /m", "f_max": "200 /m"}}})",
       1536, 2400},
      {"infrared-6.5m",
       R"({"aberfit": 1, "mirror": {"focal_length": "52 m"},
           "aperture": {"shape": "annulus", "diameter": "6.5 m", "inner_diameter": "0.9 m"},
           "light": {"wavelength": "2 um"},
           "roughness": {"psd": {"model": "k-correlation", "rms": "40 nm", "B": "0.6 m", "exponent": 2.6,
                                 "f_min": "0.3 /m", "f_max": "100 /m"}}})",
       2048, 3200},
      {"euv",
       R"({"aberfit": 1, "mirror": {"focal_length": "2 m"}, "aperture": {"shape": "circle", "diameter": "0.2 m"},
           "light": {"wavelength": "13.5 nm"},
           "roughness": {"psd": {"model": "power-law", "rms": "0.25 nm", "exponent": 2.9, "f_min": "10 /m",
                                 "f_max": "1000 /m"}}})",
       768, 1600},
      {"wide-300", wide("750"), 1024, 1800},
      {"wide-1000", wide("2500"), 3200, 5000},
      {"wide-3000", wide("7500"), 9600, 15000}};
  return scenes;
}

}  // namespace aberfit
