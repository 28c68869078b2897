#pragma once
#include <initializer_list>

#include "aberfit/report/focal_light.h"

namespace aberfit::internal {

// How much of the focus pictures and arrays show.

/// A spot size [m] to scale axes by: `core_sigma` where that is known, or that of the first of `lights` that
/// has one.
double spot_scale(double core_sigma, std::initializer_list<const FocalLight*> lights);

/// ee98 at plane dz, or where most of the light is: the last per cent of a diffracted spot reach out
/// endlessly. [m]
double curve_end(const FocalLight& light, double dz = 0);

/// Half the width of an image [m] of a spot with this ee90 radius at z = f.
double image_half_width(double ee90, double scale);

}  // namespace aberfit::internal
