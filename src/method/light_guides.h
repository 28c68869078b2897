#pragma once
#include <vector>

#include "aberfit/method/groundwork.h"
#include "aberfit/method/task.h"

namespace aberfit::internal {

/// Shares of light inside rings, between the fitted planes and fractions, that tie the light of a diffracted
/// spot there. Without them a fit leaves speckle: grains of wavelength f-numbers across and 8 wavelength
/// f-numbers^2 deep, by whose number the energy between two fitted radii is free to vary (fits of the
/// README's study were 1-3 % off there). planes: fitted ones, dz [m]. Tolerances are
/// law::kGuideShareOfMargin of the margin times max(r dE/dr, kFlattestCurve). The ground has a mean spot.
std::vector<Target> light_guides(const Task& task, const Groundwork& ground,
                                 const std::vector<double>& planes, int threads);

}  // namespace aberfit::internal
