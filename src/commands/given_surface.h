#pragma once
#include <optional>

#include "aberfit/commands/run_options.h"
#include "aberfit/method/trace_surface.h"
#include "aberfit/report/result.h"
#include "aberfit/scene/segments.h"

namespace aberfit::internal {

/// The surface of the options, in memory or in a file; nothing if there is none. Throws InputError like
/// read_coefficients_csv.
inline std::optional<GivenSurface> given_surface(const Study& study, const RunOptions& options) {
  if (options.surface) return *options.surface;
  if (options.coefficients_file.empty()) return std::nullopt;
  GivenSurface surface;
  surface.terms.radius = aperture_radius(study.aperture);
  surface.terms.segments = erring_segments(study.aperture);
  surface.coefficients = read_coefficients_csv(options.coefficients_file, &surface.terms);
  return surface;
}

}  // namespace aberfit::internal
