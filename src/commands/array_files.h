#pragma once
#include <memory>
#include <string>
#include <vector>

#include "aberfit/commands/program.h"
#include "aberfit/commands/run_options.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/report/arrays.h"
#include "aberfit/report/focal_light.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// The format on the command line, otherwise the study's.
ArrayFormat wanted_arrays(const Study& study, const RunOptions& options);
/// The format of this name. Precondition: the name is one of array_format_names.
ArrayFormat array_format(const std::string& word);

/// Names of a ResultClaim.
std::vector<std::string> array_claims(ArrayFormat format);
/// The claim of a command that writes nothing but arrays and its printed result.
ResultClaim claim_of_arrays(const std::string& command, const RunOptions& options, ArrayFormat format);

/// Sets the folder of a command that writes only arrays. Throws InputError for a folder to which nothing
/// would be written.
void choose_arrays_directory(const Study& study, const RunOptions& options, const std::string& command,
                             CommandLine* line);

/// The PSF by the theory that gives the targets; by rays it uses the points of `pupil`. Null without
/// roughness.
std::unique_ptr<FocalLight> target_light(const Study& study, const Groundwork& ground,
                                         const PupilSample& pupil, int threads);

/// Planes dz [m] of the encircled energies among the statistics.
std::vector<double> planes_of(const std::vector<Statistic>& statistics);

/// The input of the arrays of a study. theory, surface: either may be null; they must outlive the input.
ArrayInput array_input(const Study& study, const Groundwork& ground, const FocalLight* theory,
                       const FocalLight* surface, const std::vector<double>& planes);

/// Writes the arrays below `folder`. Arrays that cannot be made are left out with the warning
/// `arrays-left-out`, so that a finished run is not lost.
void write_arrays(const ArrayInput& input, ArrayFormat format, const std::string& folder, Warnings* warnings);

}  // namespace aberfit::internal
