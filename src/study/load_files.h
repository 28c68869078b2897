#pragma once
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// Loads the PSD tables and ring-through profiles that the study names; relative paths start at the folder of
/// `study.path`. Throws InputError at the pointer of the `file` key for files that are missing or do not
/// parse.
void load_files(Study& study);

}  // namespace aberfit::internal
