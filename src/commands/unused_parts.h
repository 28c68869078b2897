#pragma once
#include <string>

#include "aberfit/core/warning.h"
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// Warns that a command computes only the mirror, while the study describes more of the light's path: one
/// warning `contributors-not-used`, or none. remedy: the command to run instead, e.g. "`aberfit solve`".
Warnings unused_parts(const Study& study, const std::string& remedy);

}  // namespace aberfit::internal
