#pragma once
#include "aberfit/roughness/psd.h"
#include "aberfit/scene/aperture.h"

namespace aberfit {

class PsdDerivative;

/// RMS height [m] of roughness about its mean over the aperture, as in RmsHeight. The ensemble mean of its
/// square is
///   (2 pi/A) int_0^D (C(0) - C(s)) OTF(s) s ds,
/// with OTF that of the perfect aperture, averaged over direction (ApertureOtf), and A its area. For a PSD
/// that falls as f^-2 to f^-4 it is below the RMS height of the PSD: 0.1 to 0.4 % from one cycle across, 3 to
/// 13 % from half a cycle. It is finite where unlimited wavelengths make that infinite. Relative error below
/// 1e-5: roughness above 24 cycles across counts with its full height. Infinite where the height variance
/// diverges at high frequency.
double rms_height_on(const Aperture& aperture, const RadialPsd& psd);
/// Derivative of its square [m^2 per unit of p], by the same integral; NaN where the square is infinite.
double height_variance_change_on(const Aperture& aperture, const RadialPsd& psd,
                                 const PsdDerivative& derivative);

}  // namespace aberfit
