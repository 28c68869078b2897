#pragma once
#include "aberfit/trace/ray_bundle.h"

namespace aberfit {

/// The paper's way to a ring FWHM: N(z) sampled at multiples of `pitch` [m] from z = f, number of samples at
/// or above half the largest one times the pitch [m]. Low by up to one pitch against the interpolated width
/// (PHYSICS 9: 2.9 for 2.985 mm, 0.3 for 0.396 mm). Samples reach `reach` [m] to both sides.
double counted_ring_width(const RayBundle& rays, double ring_radius, double pitch, double reach);

}  // namespace aberfit
