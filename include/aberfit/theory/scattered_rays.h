#pragma once
#include <cstdint>

#include "aberfit/scene/pupil.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {

/// Adds to `field` the random slopes by which unmodelled roughness deflects rays; an empty `field` becomes
/// one of zeros. Every pupil point gets a Gaussian slope on each axis, of standard deviation
/// `scatter.rms_slope_per_axis()`, independent of the surface. That is the slope of Gaussian roughness at one
/// point, and a ray depends on one point only (PHYSICS 5). So the mean over such rays is the mean over such
/// mirrors. The slopes come from a scrambled Sobol set. They keep its order where neighbours of the pupil
/// follow each other. Elsewhere their order is random.
void add_scatter(const MeanScatter& scatter, const PupilSample& pupil, std::uint64_t seed,
                 SurfaceField* field);
/// Seed for the pupil that a study names; fresh pupils use other seeds.
inline constexpr std::uint64_t kScatterSeed = 1;

}  // namespace aberfit
