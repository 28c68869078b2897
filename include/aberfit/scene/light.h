#pragma once
#include <vector>

namespace aberfit {

/// One wavelength [m] of the source, and its fraction of the total irradiance.
struct LightLine {
  double wavelength = 0;
  double share = 1;
  bool operator==(const LightLine&) const = default;
};

/// Collimated light of one wavelength, or of several whose irradiances add. It converts to a number, the mean
/// wavelength weighted by the fractions.
class Light {
 public:
  Light() = default;
  Light(double wavelength) : lines_{{wavelength, 1}} {}  ///< [m]
  /// The fractions are normalised to a sum of 1. Throws std::invalid_argument without lines, or when a
  /// wavelength or fraction is not positive and finite.
  explicit Light(std::vector<LightLine> lines);

  operator double() const { return mean_wavelength(); }
  double mean_wavelength() const;
  bool is_band() const { return lines_.size() > 1; }
  const std::vector<LightLine>& lines() const { return lines_; }
  double shortest() const;  ///< [m]
  double longest() const;   ///< [m]
  /// Multiplies all wavelengths by `ratio`.
  Light& operator*=(double ratio);
  bool operator==(const Light&) const = default;

 private:
  std::vector<LightLine> lines_{{0, 1}};
};

/// `count` lines of equal irradiance at the centres of `count` equal parts of the band `from` .. `to` [m].
Light band_of_light(double from, double to, int count);

}  // namespace aberfit
