#pragma once
#include <optional>

#include "aberfit/roughness/psd.h"

namespace aberfit {

/// The part of a model inside [f_min, f_max] [cycles/m], as a model again: uniform, k-correlation and power
/// law are themselves with the narrower band (`rms` being that of it, an `amplitude` staying), a table is
/// cut, its ends interpolated; a sum is the sum of its parts, those outside left out (one that is left stands
/// alone). A Gaussian that is cut, which has no parameters for it, becomes a table that log-log interpolation
/// holds to 1e-3 of S, from where 1e-12 of its height variance lies below to where 1e-26 lies above. Equals
/// RadialPsd(model).band(f_min, f_max) otherwise. f_min < f_max, both may be open (0, infinity). Empty
/// when nothing is inside.
std::optional<PsdModel> psd_in_band(const PsdModel& model, double f_min, double f_max);

}  // namespace aberfit
