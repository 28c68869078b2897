#pragma once
#include "aberfit/commands/run.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/report/result.h"
#include "aberfit/report/result_folder.h"

namespace aberfit::internal {

/// The files that `write_fit` may write.
ResultClaim claim_of_fit(const Study& study, const RunOptions& options);

/// Writes result.json, coefficients.csv, summary.txt and - when wanted - the pictures of a fit below
/// options.output_directory. A missing gnuplot becomes a warning of the result.
void write_fit(const Study& study, const Groundwork& ground, const RunOptions& options,
               const LightPath& focus, ResultDocument* result);

}  // namespace aberfit::internal
