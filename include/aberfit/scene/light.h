#pragma once
#include <vector>

namespace aberfit {

/// One wavelength of the light [m], and its share of all light.
struct LightLine {
  double wavelength = 0;
  double share = 1;
  bool operator==(const LightLine&) const = default;
};

/// Collimated light of one wavelength, or of a few whose energies add. Where a number is wanted it is the
/// mean wavelength, weighted by shares.
class Light {
 public:
  Light() = default;
  Light(double wavelength) : lines_{{wavelength, 1}} {}  ///< [m]
  /// Shares are those of their sum. Throws std::invalid_argument without lines, and for wavelengths or shares
  /// that are not positive and finite.
  explicit Light(std::vector<LightLine> lines);

  operator double() const { return mean_wavelength(); }
  double mean_wavelength() const;
  bool is_band() const { return lines_.size() > 1; }
  const std::vector<LightLine>& lines() const { return lines_; }
  double shortest() const;  ///< [m]
  double longest() const;   ///< [m]
  /// All wavelengths times `ratio`.
  Light& operator*=(double ratio);
  bool operator==(const Light&) const = default;

 private:
  std::vector<LightLine> lines_{{0, 1}};
};

/// `count` lines of equal share from `from` to `to` [m]: the middles of as many equal parts of the band.
Light band_of_light(double from, double to, int count);

}  // namespace aberfit
