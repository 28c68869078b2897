#pragma once
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// Loads the PSD tables, ring-through profiles and foci that the study names and does not hold yet. Makes
/// `psd` from the roughness if it is missing. Relative paths start at the folder of `study.path`. Throws
/// InputError at the pointer of the `file` key for files that are missing or do not parse.
void load_files(Study& study);

}  // namespace aberfit::internal
