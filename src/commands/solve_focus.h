#pragma once
#include <vector>

#include "aberfit/commands/run_options.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/specify/psd_of_focus.h"
#include "aberfit/specify/solve.h"
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// The numbers that the study's `solve` block looks for, with their starts. Throws InputError for a pointer
/// to anything else.
std::vector<SolveUnknown> solve_unknowns(const Study& study);

/// The files of a roughness found from a measured focus.
ResultClaim claim_of_focus(const Study& study, const RunOptions& options);
/// Writes them, if a folder is wanted.
void write_focus(const Study& study, const RunOptions& options, ResultFolder* folder, PsdOfFocus* result);

}  // namespace aberfit::internal
