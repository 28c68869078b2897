#pragma once
#include <filesystem>
#include <string>

#include "aberfit/study/study.h"

namespace aberfit {

/// Scene k = 0 .. kWideScenes - 1 of a seeded generator of ordinary smooth mirrors with wide bands. Apertures
/// of 5 mm to 10 m, f/1.5 to f/40: a circle, an annulus, a rectangle or a hexagon. Wavelengths 13.5 nm to
/// 10.6 um, g from 0.1 to 2 (flat spectra to 1), five families of PSDs, 100 to 3000 cycles across as far as
/// they scatter by less than 8.6 degrees. Everything else has its default.
struct WideScene {
  std::string name;
  double cycles = 0;  ///< of the band across the aperture
  std::string study;  ///< JSON
  std::string table;  ///< what the file kWideTable beside the study holds; empty: the study names none
};
inline constexpr int kWideScenes = 60;
inline constexpr const char* kWideTable = "psd.txt";
WideScene wide_scene(int k);

/// The study of a scene. folder: its table is written there, if it has one.
Study study_of(const WideScene& scene, const std::filesystem::path& folder);

}  // namespace aberfit
