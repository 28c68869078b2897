#pragma once
#include <vector>

#include "aberfit/measured/height_map.h"
#include "aberfit/method/character.h"

namespace aberfit::internal {

/// The surface at 0.7, 1.5 and 3 times the wavelength and behind a stop of 60 %, with the rest of its
/// roughness as scatter, against generalised Harvey-Shack. draws: random surfaces of the low part.
std::vector<OtherLight> other_light(const Task& task, const Groundwork& ground, const TermSet& terms,
                                    const Eigen::VectorXd& coefficients, const std::vector<HeightMap>& draws,
                                    const RunContext& context);

}  // namespace aberfit::internal
