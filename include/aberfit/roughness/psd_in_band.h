#pragma once
#include <optional>

#include "aberfit/roughness/psd.h"

namespace aberfit {

/// The part of a model inside [f_min, f_max] [cycles/m], as a model. f_min < f_max; both may be open (0,
/// infinity). Returns nothing when no part is inside.
/// Uniform, k-correlation and power law keep their type with the narrower band; `rms` becomes that of the
/// band, an `amplitude` stays. A table is cut, with interpolated ends. A sum becomes the sum of its parts
/// inside; a single part stands alone.
/// A cut Gaussian has no parameters of its own, so it becomes a table. Its log-log interpolation is within
/// 1e-3 of S, and it covers the band from 1e-12 of the height variance below to 1e-26 above. All others equal
/// RadialPsd(model).band(f_min, f_max).
std::optional<PsdModel> psd_in_band(const PsdModel& model, double f_min, double f_max);

}  // namespace aberfit
