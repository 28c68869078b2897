#pragma once
#include <cstdint>

#include "aberfit/scene/pupil.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {

/// Roughness as it turns rays where no surface stands for it: at every pupil point a Gaussian slope in each
/// axis, of the standard deviation `scatter.rms_slope_per_axis()`, independent of the surface. That is the
/// slope of Gaussian roughness at a point, and light on rays knows of no more than one point (PHYSICS 5): the
/// mean over such rays is the mean over such mirrors. The slopes are spread evenly (a scrambled Sobol set of
/// their own, in its order where neighbours of the pupil follow each other, else dealt out at random; seeds
/// are independent where they are dealt out).
/// Adds to the slopes of `field`, which is made a field of zeros where it is empty.
void add_scatter(const MeanScatter& scatter, const PupilSample& pupil, std::uint64_t seed,
                 SurfaceField* field);
/// Of the pupil that a study names; fresh pupils take seeds of their own.
inline constexpr std::uint64_t kScatterSeed = 1;

}  // namespace aberfit
