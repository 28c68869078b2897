#pragma once
#include <vector>

#include "aberfit/method/groundwork.h"
#include "aberfit/method/task.h"

namespace aberfit::internal {

/// Energy fractions inside rings, between the fitted planes and fractions, as guides of a fit by waves.
/// Without them a fit leaves speckle: grains of wavelength times f-number across and 8 wavelength f-number^2
/// deep, whose number lets the energy between two fitted radii vary. planes: the fitted dz [m]. Tolerance:
/// law::kGuideShareOfMargin of the margin times max(r dE/dr, kFlattestCurve). The ground has a mean spot.
std::vector<Target> light_guides(const Task& task, const Groundwork& ground,
                                 const std::vector<double>& planes, int threads);

}  // namespace aberfit::internal
