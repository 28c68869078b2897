#pragma once
#include "aberfit/roughness/psd.h"

namespace aberfit {

/// The frequencies of a surface that scatter light of a wavelength at normal incidence: those below 1/lambda,
/// whose diffraction order leaves the surface (relevant roughness; PHYSICS 6).
struct ScatteringBand {
  RadialPsd psd;          ///< without what is cut
  double rms_height = 0;  ///< of it [m]; infinity where the variance diverges at f = 0
  double cut_share = 0;   ///< share of the height variance above 1/lambda
};
/// wavelength > 0 [m]. A share below 1e-12, less than any result shows, is left where it is, with the closed
/// forms that an unlimited band has. What is cut of an infinite variance counts as a share of the part above
/// the frequency 1/(1000 m), which no mirror exceeds.
ScatteringBand scattering_band(const RadialPsd& psd, double wavelength);

}  // namespace aberfit
