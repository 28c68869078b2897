#pragma once
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace aberfit::test {

/// Reads a listing of Zernike Standard coefficients as another program would, from the description of the
/// format alone.
struct ZernikeListing {
  double wavelength = 0, radius = 0;     ///< [m]
  std::vector<double> waves;             ///< by Noll index from 1
  std::vector<std::string> polynomials;  ///< as printed beside them
};

inline ZernikeListing read_zernike_listing(const std::string& text) {
  static const std::regex kRow(R"(Z +(\d+)\t *(\S+)\t:\t(.*))");
  static const std::regex kLength(R"((Wavelength|Normalization radius) *:\t(\S+) (um|mm))");
  ZernikeListing listing;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (std::smatch m; std::regex_match(line, m, kRow)) {
      listing.waves.push_back(std::stod(m[2]));
      listing.polynomials.push_back(m[3]);
      if (std::stoul(m[1]) != listing.waves.size()) throw std::runtime_error("not in order: " + line);
    } else if (std::regex_match(line, m, kLength)) {
      (m[1] == "Wavelength" ? listing.wavelength : listing.radius) =
          std::stod(m[2]) * (m[3] == "um" ? 1e-6 : 1e-3);
    }
  }
  return listing;
}

}  // namespace aberfit::test
