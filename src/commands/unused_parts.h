#pragma once
#include <string>

#include "aberfit/core/warning.h"
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// What the study says of the light's path beside the mirror, where a command computes the mirror alone: one
/// warning `contributors-not-used`, or none. remedy: what to run instead, e.g. "`aberfit solve`".
Warnings unused_parts(const Study& study, const std::string& remedy);

}  // namespace aberfit::internal
