#include "aberfit/core/output_formats.h"

namespace aberfit {

const std::vector<std::string>& picture_format_names() {
  static const std::vector<std::string> names = {"auto", "png", "svg", "pdf", "none"};
  return names;
}

const std::vector<std::string>& array_format_names() {
  static const std::vector<std::string> names = {"none", "npz", "csv", "fits"};
  return names;
}

const std::vector<std::string>& export_names() {
  static const std::vector<std::string> names = {"zemax-grid-sag", "zernike-noll", "codev-int",
                                                 "codev-zfr",      "fits-opd",     "csv"};
  return names;
}

}  // namespace aberfit
