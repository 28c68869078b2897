#pragma once
#include <cstdint>

#include "aberfit/theory/vocabulary.h"
#include "aberfit/trace/ray_bundle.h"

namespace aberfit {

/// The Harvey-Shack branch by ray perturbation: every ray gets an independent Gaussian slope error of
/// per-axis deviation `slope`. kPhysical: added to the surface gradient before reflection. kPaper: D = -slope
/// added to x and y of the reflected unit vector, which is renormalised. Random numbers: stream
/// ("harvey-shack", seed), index = ray number.
RayBundle trace_perturbed(const Mirror& mirror, const PupilSample& pupil, double slope, Convention convention,
                          std::uint64_t seed);

/// The same with given slope errors (2 x N, e.g. the gradient of a synthesised phase), one column per pupil
/// point. Rays are lost as in `trace`, and where a slope error is not finite.
RayBundle trace_perturbed(const Mirror& mirror, const PupilSample& pupil, const Eigen::Array2Xd& slope_error,
                          Convention convention);

}  // namespace aberfit
