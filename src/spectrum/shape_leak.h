#pragma once
#include <optional>

#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit::internal {

/// Returns the comparison shape: a polynomial of four more degrees.
DetrendOptions detrended_further(const DetrendOptions& options, bool profile);

/// Returns false if shape_leak certainly finds nothing; true if it must be called. further: PSD of the same
/// bins after further detrending [m^3 or m^4].
bool may_leak(const PsdEstimate& estimate, const Eigen::ArrayXd& further);

/// The range of frequencies into which a shape leaks that detrending has left.
struct ShapeLeak {
  double frequency = 0;     ///< upper edge of the highest bin affected [cycles/m]
  double excess = 1;        ///< largest factor by which a bin falls if four more degrees are subtracted
  bool everywhere = false;  ///< true: fewer than six bins lie above
};
/// Compares an estimate with `further`, that of the further detrended surface in the same bins. From eight
/// frequency steps on, roughness loses little to four more degrees, so that a bin that falls to half of what
/// the response predicts is leakage. Below, a bin must also be above the line through the higher bins beyond
/// chance. False alarms: four in 16,000 stationary profiles with PSD f^-1 to f^-4.
std::optional<ShapeLeak> shape_leak(const PsdEstimate& estimate, const PsdEstimate& further);

}  // namespace aberfit::internal
