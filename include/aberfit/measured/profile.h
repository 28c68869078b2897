#pragma once
#include <Eigen/Core>
#include <string>

namespace aberfit {

/// Physical quantity of a measured profile.
enum class ProfileQuantity {
  kHeight,  ///< [m]
  kSlope,   ///< dz/dx of the surface [rad]
};

/// One scan line over a surface. Readers convert a measured wavefront to the surface by halving it.
struct Profile {
  Eigen::ArrayXd x;      ///< position [m], strictly ascending; the pitch may be uneven
  Eigen::ArrayXd value;  ///< height [m] or slope [rad], NaN where there is no valid measurement
  ProfileQuantity quantity = ProfileQuantity::kHeight;
  std::string label;     ///< description in the file; may be empty
  double file_unit = 1;  ///< surface height [m] or slope [rad] that corresponds to a value of 1 in the file
  Eigen::Index said_invalid = 0;  ///< number of samples that have a value of MeasuredSource::invalid

  Eigen::Index size() const { return x.size(); }
};

/// Returns the number of samples with a value.
Eigen::Index valid_count(const Profile& profile);
/// Returns the median distance between neighbours [m].
double median_pitch(const Profile& profile);

}  // namespace aberfit
