#pragma once
#include <optional>

#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit::internal {

/// What the side lobes of the window carry up a steep spectrum.
struct WindowLeak {
  double frequency = 0;  ///< of the lowest bin that holds it [cycles/m]
  double share = 0;      ///< largest share of a bin that comes from below half of its frequency
};

/// Leakage of the spectrum as its bins show it, by the response of the estimate, in bins of 16 steps of
/// frequency and more up to `trusted_to`. Empty where it stays below kMostLeaked. A spectrum that is steeper
/// than the side lobes shows itself as these, and then a fiftieth and more of a bin comes from below: without
/// window from f^-1.5 on, Hamming f^-2.5, Welch f^-4, Tukey and Blackman-Harris f^-5, Hann before f^-6
/// (tests/stability/leakage_edge_test.cpp).
std::optional<WindowLeak> window_leak(const PsdEstimate& estimate);
inline constexpr double kMostLeaked = 0.02;

}  // namespace aberfit::internal
