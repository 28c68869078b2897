#pragma once
#include "aberfit/roughness/psd.h"

namespace aberfit {

/// The frequencies of a surface that scatter at a wavelength and normal incidence. They lie below 1/lambda,
/// so that their diffraction order leaves the surface (relevant roughness; PHYSICS 6).
struct ScatteringBand {
  RadialPsd psd;          ///< the part below 1/lambda
  double rms_height = 0;  ///< RMS of `psd` [m]; infinity where the variance diverges at f = 0
  double cut_share = 0;   ///< fraction of the height variance above 1/lambda
};
/// wavelength > 0 [m]. A cut fraction below 1e-12 does not show in any result; then the PSD is not cut and
/// keeps its closed forms. For an infinite variance, cut_share refers to frequencies above 1/(1000 m).
ScatteringBand scattering_band(const RadialPsd& psd, double wavelength);

}  // namespace aberfit
