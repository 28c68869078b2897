#pragma once
#include <string>
#include <vector>

#include "aberfit/method/groundwork.h"

namespace aberfit {

/// A number of the mean light as specifications limit it; its key is that of a budget (specify/budget.h).
struct SpecifiedValue {
  std::string key;        ///< "ee80_diameter", "strehl", "pssn@0.15m"
  double value = 0;       ///< [m] of a width, else [1]; infinite, NaN where it does not exist
  bool is_width = false;  ///< in the focus: an angle on the sky over f as well
};

/// The mean light of a specification in the focus.
struct SpecifiedLight {
  std::string theory;       ///< "ghs", "geometric"; empty where neither is the scene's
  double focal_length = 0;  ///< [m]
  /// By GHS ee50, ee80 and ee90 diameters, hew, fwhm, ensquared80_side, strehl, tis and pssn@0.15m; by rays
  /// the diameters and hew. Milliseconds; Strehl ratio and PSSN are left out, for a budget to ask for, where
  /// the perfect parabola costs tenths of a second: of a pupil without symmetry on another mirror.
  std::vector<SpecifiedValue> values;
  /// The light of each wavelength of a band by itself; empty for one wavelength.
  struct Line {
    double wavelength = 0, share = 0;             // [m], of all light
    double ee50_diameter = 0, ee80_diameter = 0;  // [m]
  };
  std::vector<Line> lines;
};
SpecifiedLight specified_light(const Groundwork& ground);

}  // namespace aberfit
