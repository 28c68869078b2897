#pragma once
#include <cstdint>
#include <map>
#include <string>

namespace aberfit {

/// Scene k = 0, 1, ... of a seeded generator over all that a study can say. Apertures of 5 mm to 10 m, f/1 to
/// f/40: circles, annuli, rectangles and polygons, some far from the axis. Wavelengths 13.5 nm to 10.6 um, g
/// from 0.02 to 50, 3 to 3000 cycles across, six families of PSDs. Some have conics, known Zernikes, terms
/// that the study names, theory geometric, statistics or planes by name. Three of five leave everything open.
/// Heights and bands scatter by less than 8.6 degrees, except in scenes of the kind "grazing".
struct RandomScene {
  std::string name;
  /// Classes by which rows are counted: kind, psd, aperture, g, cycles, light, f-number.
  std::map<std::string, std::string> classes;
  bool all_open = false;  ///< four blocks: terms, statistics, theory and rays are left to the program
  std::string study;      ///< JSON
  std::string table;      ///< what the file kRandomTable beside the study holds; empty: the study names none
};
inline constexpr const char* kRandomTable = "psd.txt";
RandomScene random_scene(std::uint64_t seed, int k);

}  // namespace aberfit
