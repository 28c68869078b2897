#pragma once
#include <string>

#include "aberfit/focus/statistic.h"

namespace aberfit {

/// Why an encircled-energy radius cannot be met: it lies well below `perfect` [m], that of the perfect
/// mirror's diffraction pattern in focus. Empty when it does not. Phases can narrow single rings of a pattern
/// a little, hence a share of 2 % beside the tolerance.
std::string below_diffraction(const Target& target, double perfect);

}  // namespace aberfit
