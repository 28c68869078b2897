#pragma once
#include <memory>
#include <string>
#include <vector>

#include "aberfit/commands/program.h"
#include "aberfit/commands/run_options.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/report/focal_light.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// What the command line says, else the study.
ArrayFormat wanted_arrays(const Study& study, const RunOptions& options);
/// Of its word, which has to be one of array_format_names.
ArrayFormat array_format(const std::string& word);

/// Names of a ResultClaim.
std::vector<std::string> array_claims(ArrayFormat format);
/// Those of a command that writes nothing but arrays and what it prints.
ResultClaim claim_of_arrays(const std::string& command, const RunOptions& options, ArrayFormat format);

/// Sets the folder of a command that writes nothing but arrays. Throws InputError for a folder that nothing
/// would be written to.
void choose_arrays_directory(const Study& study, const RunOptions& options, const std::string& command,
                             CommandLine* line);

/// Light by the theory that the targets come from, by rays at the points of `pupil`; null without roughness.
std::unique_ptr<FocalLight> target_light(const Study& study, const Groundwork& ground,
                                         const PupilSample& pupil, int threads);

/// Planes dz [m] of the encircled energies among the statistics.
std::vector<double> planes_of(const std::vector<Statistic>& statistics);

/// Writes the arrays of both lights, either of which may be null, below `folder`. What cannot be made is left
/// out with the warning `arrays-left-out`: a run that is done is not lost for it.
void write_arrays(const Study& study, ArrayFormat format, const FocalLight* theory, const FocalLight* surface,
                  const std::vector<double>& planes, double core_sigma, const std::string& folder,
                  Warnings* warnings);

}  // namespace aberfit::internal
