#pragma once
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// Loads the PSD tables and ring-through profiles that the study names; relative paths start at the folder of
/// `study.path`. Throws InputError at the pointer of the `file` key for files that are missing or do not
/// parse. same_roughness: a study with the same roughness, whose files and measurements are taken over; or
/// null.
void load_files(Study& study, const Study* same_roughness = nullptr);

}  // namespace aberfit::internal
