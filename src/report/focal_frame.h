#pragma once
#include <initializer_list>

#include "aberfit/report/focal_light.h"

namespace aberfit::internal {

// These functions choose the part of the focus that pictures and arrays show.

/// Spot size [m] that scales axes: `core_sigma` if known, else that of the first of `lights` that has one.
double spot_scale(double core_sigma, std::initializer_list<const FocalLight*> lights);

/// Last radius [m] of an encircled-energy curve: ee98 at plane dz, but at most twice ee90, because the last
/// per cent of a diffracted spot extends without end.
double curve_end(const FocalLight& light, double dz = 0);

/// Half width [m] of the image of a spot with this ee90 radius at z = f.
double image_half_width(double ee90, double scale);

}  // namespace aberfit::internal
