#pragma once
#include <limits>

#include "aberfit/roughness/psd.h"

namespace aberfit {

/// One-sided PSD of a profile, S1(f) = amplitude (1 + (B f)^2)^(-exponent/2) [m^3] for f > 0 [cycles/m], with
/// int_0^inf S1 df = variance.
struct KCorrelation1d {
  double amplitude = 0;    ///< [m^3]
  double correlation = 0;  ///< B [m]
  double exponent = 0;     ///< 1-D: S1 falls as f^-exponent at large f
};
/// Two-sided PSD of an isotropic surface, S2(f) = amplitude (1 + (B f)^2)^(-exponent/2) [m^4].
struct KCorrelation2d {
  double amplitude = 0;    ///< [m^4]
  double correlation = 0;  ///< B [m]
  double exponent = 0;     ///< 2-D: one more than that of the profile
};

/// The surface whose profiles have S1: exponent C -> C + 1, amplitude A -> A B Gamma((C+1)/2) / (2 sqrt(pi)
/// Gamma(C/2)), for the band 0..infinity, where int S2 df_y = S1/2 (Church and Takacs; FORMATS, PSD
/// conventions). A two-sided S1 is half the one-sided one, so double its amplitude first. Throws
/// std::domain_error unless C > 0.
KCorrelation2d k_correlation_1d_to_2d(const KCorrelation1d& profile);
/// The inverse. Throws std::domain_error unless the 2-D exponent exceeds 1 (else profiles have no finite
/// PSD).
KCorrelation1d k_correlation_2d_to_1d(const KCorrelation2d& surface);

/// The model in a band, whose RMS is `rms`. Throws std::domain_error if the height variance is not finite.
KCorrelationPsd k_correlation_model(const KCorrelation2d& surface, double f_min = 0,
                                    double f_max = std::numeric_limits<double>::infinity());

}  // namespace aberfit
