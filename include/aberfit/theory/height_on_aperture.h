#pragma once
#include "aberfit/roughness/psd.h"
#include "aberfit/scene/aperture.h"

namespace aberfit {

class PsdDerivative;

/// RMS height [m] of roughness about its mean over the aperture: what a mirror of this aperture has, and what
/// RmsHeight is. The ensemble mean of its square is
///   (2 pi/A) int_0^D (C(0) - C(s)) OTF(s) s ds,
/// OTF that of the perfect aperture in the mean over directions (ApertureOtf), A its area. Of a PSD that
/// falls as f^-2 to f^-4 from one cycle across it is 0.1 to 0.4 % below the RMS height of the PSD, from half
/// a cycle 3 to 13 %; finite where waves without end make that infinite. Relative error below 1e-5: roughness
/// of more than 24 cycles across enters with all of its height. Infinite where the height variance diverges
/// at high frequency.
double rms_height_on(const Aperture& aperture, const RadialPsd& psd);
/// The derivative of its square [m^2 per unit of p], by the same integral; NaN where the square is infinite.
double height_variance_change_on(const Aperture& aperture, const RadialPsd& psd,
                                 const PsdDerivative& derivative);

}  // namespace aberfit
