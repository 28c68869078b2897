#pragma once
#include <string>
#include <vector>

#include "aberfit/method/groundwork.h"

namespace aberfit {

/// A specified statistic of the mean irradiance. Its key is that of a budget (specify/budget.h).
struct SpecifiedValue {
  std::string key;        ///< "ee80_diameter", "strehl", "pssn@0.15m"
  double value = 0;       ///< [m] for a width, else [1]; infinite or NaN where it does not exist
  bool is_width = false;  ///< a length in the focus; over f it is an angle on the sky
};

/// The mean irradiance of a specification in the focus.
struct SpecifiedLight {
  std::string theory;       ///< "ghs", "geometric"; empty where neither applies
  double focal_length = 0;  ///< [m]
  /// GHS gives ee50, ee80 and ee90 diameters, hew, fwhm, ensquared80_side, strehl, tis and pssn@0.15m; rays
  /// give the diameters and hew. Strehl ratio and PSSN are left out where the perfect parabola takes long: a
  /// pupil without symmetry on a mirror that is no parabola, or a band with uneven irradiance. A budget can
  /// request them.
  std::vector<SpecifiedValue> values;
  /// Each wavelength of a band by itself; empty for one wavelength.
  struct Line {
    double wavelength = 0, share = 0;             // [m], fraction of the total energy
    double ee50_diameter = 0, ee80_diameter = 0;  // [m]
  };
  std::vector<Line> lines;
};
SpecifiedLight specified_light(const Groundwork& ground);

}  // namespace aberfit
