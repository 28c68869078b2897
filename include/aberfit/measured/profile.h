#pragma once
#include <Eigen/Core>
#include <string>

namespace aberfit {

/// What the numbers of a measured profile are.
enum class ProfileQuantity {
  kHeight,  ///< [m]
  kSlope,   ///< dz/dx of the surface [rad]
};

/// One scan line over a surface. Always the surface: readers halve what was measured on a wavefront.
struct Profile {
  Eigen::ArrayXd x;      ///< position [m], strictly ascending; the pitch may be uneven
  Eigen::ArrayXd value;  ///< height [m] or slope [rad], NaN where there is no valid measurement
  ProfileQuantity quantity = ProfileQuantity::kHeight;
  std::string label;     ///< what the file says it is; may be empty
  double file_unit = 1;  ///< a value of 1 in the file is this height [m] or slope [rad] of the surface
  Eigen::Index said_invalid = 0;  ///< samples that are holes because MeasuredSource::invalid has their value

  Eigen::Index size() const { return x.size(); }
};

/// Number of samples with a value.
Eigen::Index valid_count(const Profile& profile);
/// Median distance of neighbours [m].
double median_pitch(const Profile& profile);

}  // namespace aberfit
