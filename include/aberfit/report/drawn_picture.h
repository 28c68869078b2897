#pragma once
#include <string>

#include "aberfit/core/output_formats.h"

namespace aberfit {

/// Options for drawing pictures.
struct PictureOptions {
  PictureFormat format = PictureFormat::kAuto;  ///< kNone: writes nothing
  int threads = 1;                              ///< pictures drawn at the same time; does not change them
};

/// A picture that was drawn, with its texts for a document.
struct DrawnPicture {
  std::string name;     ///< name of the script without extension
  std::string file;     ///< path in the folder of the results: "plots/ee_curves.svg"
  std::string title;    ///< a few words
  std::string caption;  ///< content and reading, one to three sentences
  std::string alt;      ///< description for readers who cannot see it
};

}  // namespace aberfit
