#pragma once
#include <optional>

#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit::internal {

/// Leakage of a steep spectrum through the side lobes of the window towards high frequencies.
struct WindowLeak {
  double frequency = 0;  ///< lowest bin affected [cycles/m]
  double share = 0;      ///< largest fraction of a bin that comes from below half of its frequency
};

/// Computes the leakage of the binned spectrum from the response of the estimate, in bins from 16 frequency
/// steps up to `trusted_to`. Empty if it stays below kMostLeaked.
/// A spectrum steeper than the side lobes takes on their slope, and then at least a fiftieth of a bin comes
/// from below. This happens without window from f^-1.5 on, Hamming f^-2.5, Welch f^-4, Tukey and
/// Blackman-Harris f^-5, Hann before f^-6 (tests/stability/leakage_edge_test.cpp).
std::optional<WindowLeak> window_leak(const PsdEstimate& estimate);
inline constexpr double kMostLeaked = 0.02;

}  // namespace aberfit::internal
