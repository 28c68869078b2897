#pragma once
#include <optional>

#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit::internal {

/// The shape that is taken off for comparison: a polynomial of four degrees more.
DetrendOptions detrended_further(const DetrendOptions& options, bool profile);

/// Whether the bins of an estimate may hold leakage of a shape. further: the same bins of the surface
/// detrended further, [m^3 or m^4]. False is certain for shape_leak; true asks for it.
bool may_leak(const PsdEstimate& estimate, const Eigen::ArrayXd& further);

/// How far up in frequency a shape reaches that detrending has left.
struct ShapeLeak {
  double frequency = 0;     ///< upper edge of the highest bin that it spoils [cycles/m]
  double excess = 1;        ///< largest factor by which a bin falls when four more degrees are taken off
  bool everywhere = false;  ///< fewer than six bins lie above
};
/// further: the estimate of the surface detrended further, same bins. The roughness of a surface loses little
/// to four more degrees from eight steps of frequency on, where a shape's leakage falls by as much as the
/// shape does: there a bin that falls to half its share of the response is leakage. Below, where roughness
/// and shape are of one kind, a bin has to rise beyond chance above the line through the bins above as well.
/// Of 16,000 stationary profiles f^-1 to f^-4 four have one.
std::optional<ShapeLeak> shape_leak(const PsdEstimate& estimate, const PsdEstimate& further);

}  // namespace aberfit::internal
