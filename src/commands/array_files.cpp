#include "array_files.h"

#include <algorithm>
#include <stdexcept>

#include "aberfit/core/errors.h"
#include "aberfit/report/result.h"
#include "aberfit/theory/ray_perturbation.h"
#include "output_directory.h"

namespace aberfit::internal {

ArrayFormat wanted_arrays(const Study& study, const RunOptions& options) {
  return options.arrays.value_or(study.output.arrays);
}

ArrayFormat array_format(const std::string& word) {
  const std::vector<std::string>& names = array_format_names();
  const auto found = std::find(names.begin(), names.end(), word);
  if (found == names.end())
    throw InputError("command line", "", "--arrays \"" + word + "\"", "none, npz, csv or fits");
  return ArrayFormat(found - names.begin());
}

std::vector<std::string> array_claims(ArrayFormat format) {
  switch (format) {
    case ArrayFormat::kNone:
      return {};
    case ArrayFormat::kNpz:
      return {"arrays.npz"};
    case ArrayFormat::kCsv:
      return {"arrays/encircled_energy.csv", "arrays/ring_profile.csv", "arrays/psf_*",
              "arrays/otf_surface_*",        "arrays/mtf.csv",          "arrays/halo.csv"};
    case ArrayFormat::kFits:
      return {"psf.fits", "otf.fits"};
  }
  return {};
}

ResultClaim claim_of_arrays(const std::string& command, const RunOptions& options, ArrayFormat format) {
  return claim_of(command, options, array_claims(format));
}

void choose_arrays_directory(const Study& study, const RunOptions& options, const std::string& command,
                             CommandLine* line) {
  if (!line->output_directory.empty() && wanted_arrays(study, options) == ArrayFormat::kNone)
    throw InputError("command line", "", "--output \"" + line->output_directory + "\" but no arrays to write",
                     "--output only with --arrays npz, csv or fits, or with `output.arrays` in the study");
  choose_output_directory(line, command);
}

std::unique_ptr<FocalLight> target_light(const Study& study, const Groundwork& ground,
                                         const PupilSample& pupil, int threads) {
  if (!ground.psd) return nullptr;
  if (ground.mean_spot)
    return mean_light(ground.mean_spot, study.wavelength * study.mirror.focal_length, threads);
  return ray_light(trace_perturbed(study.mirror, pupil, ground.numbers.rms_slope_per_axis,
                                   study.target.convention, study.trace.pupil.seed),
                   trace_nominal(study.mirror, pupil), study.trace.centre);
}

std::vector<double> planes_of(const std::vector<Statistic>& statistics) {
  std::vector<double> planes;
  for (const Statistic& statistic : statistics) {
    if (const auto* ee = std::get_if<EncircledEnergyRadius>(&statistic)) planes.push_back(ee->dz);
    if (const auto* within = std::get_if<RingThrough>(&statistic); within && !within->is_point)
      planes.push_back(within->dz);
  }
  return planes;
}

ArrayInput array_input(const Study& study, const Groundwork& ground, const FocalLight* theory,
                       const FocalLight* surface, const std::vector<double>& planes) {
  const RadialPsd* rest =
      surface && ground.split && ground.split->has_rest() ? &ground.split->rest() : nullptr;
  return {theory,      surface, study.mirror, study.aperture, study.wavelength, planes, ground.core_sigma,
          study.title, rest};
}

void write_arrays(const ArrayInput& input, ArrayFormat format, const std::string& folder,
                  Warnings* warnings) {
  const auto leave_out = [&](const std::string& why) { warnings->push_back({"arrays-left-out", why}); };
  if (!input.theory && !input.surface)
    return leave_out("there is neither a theory nor a surface whose focus could be written");
  std::vector<std::pair<std::string, std::string>> files;
  try {
    const FocusArrays arrays = make_focus_arrays(input);
    if (arrays.frequency.size() == 0)
      leave_out("theory and surface are both by rays, so the arrays contain no transfer function");
    files = array_files(format, arrays);
  } catch (const ComputationError& error) {
    return leave_out(error.what());
  } catch (const std::invalid_argument& error) {
    return leave_out(error.what());
  }
  for (const auto& [name, content] : files) write_file(folder + "/" + name, content);
}

}  // namespace aberfit::internal
