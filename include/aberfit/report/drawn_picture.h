#pragma once
#include <string>

#include "aberfit/core/output_formats.h"

namespace aberfit {

/// How pictures are drawn.
struct PictureOptions {
  PictureFormat format = PictureFormat::kAuto;  ///< kNone: nothing is written at all
  int threads = 1;                              ///< pictures that are drawn at once; changes no picture
};

/// A picture that is there, with what a document says of it.
struct DrawnPicture {
  std::string name;     ///< of the script, without ending
  std::string file;     ///< below the folder of the results: "plots/ee_curves.svg"
  std::string title;    ///< a few words
  std::string caption;  ///< what it shows and what to see in it, one to three sentences
  std::string alt;      ///< what it shows, for who cannot see it
};

}  // namespace aberfit
