#include "aberfit/method/image_shift.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/method/constants.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/theory/aberrated_light.h"
#include "aberfit/trace/ray_bundle.h"

namespace aberfit {
namespace {

// Centroid of the rays of the mirror without roughness, which equals that of its irradiance.
std::array<double, 2> centroid_of_rays(const Task& task) {
  const PupilSample cells = diffraction_pupil(task.aperture, task.mirror.focal_length,
                                              2 * aperture_radius(task.aperture) / law::kLeastCells)
                                .sample;
  const RayBundle rays = trace_nominal(task.mirror, cells);
  const double all = rays.weight.sum();
  return {(rays.weight * rays.x).sum() / all, (rays.weight * rays.y).sum() / all};
}

RadialPsd roughness_of(const Task& task) {
  if (task.psd) return RadialPsd(*task.psd);
  return RadialPsd(GaussianPsd{law::kSmoothG / (4 * kPi) * task.wavelength, aperture_radius(task.aperture)});
}

// A clause about ee50; empty where the margin allows the shift. Aberrations too steep for the grid count.
std::string effect_on_radii(const Task& task) {
  try {
    const AberratedLight light(GhsPupil(task.mirror, task.aperture, task.wavelength));
    const auto [about_focus, about_centroid] = light.half_light(roughness_of(task));
    if (std::abs(about_focus / about_centroid - 1) <= task.equivalence.margin) return "";
    if (std::isfinite(about_focus) && std::isfinite(about_centroid))
      return fmt::format("ee50 is {} about the focus, {} about the centroid",
                         format_quantity(about_focus, Dimension::kLength),
                         format_quantity(about_centroid, Dimension::kLength));
  } catch (const ComputationError&) {
  }
  return "radii about the focus are about as large as that shift";
}

// With Z_2 = 2 x/R and Z_3 = 2 y/R, a surface tilt of X/(2f) moves the image by X.
std::string centring_tilt(const Task& task, const std::array<double, 2>& centroid) {
  const double radius =
      task.mirror.zernike.empty() ? aperture_radius(task.aperture) : task.mirror.zernike_radius;
  const double per_shift = radius / (4 * task.mirror.focal_length);
  std::string text;
  for (const int axis : {0, 1}) {
    const double height = per_shift * centroid[std::size_t(axis)];
    if (std::abs(height) < 1e-6 * per_shift * std::hypot(centroid[0], centroid[1])) continue;
    text += fmt::format("{}{} to Noll {}", text.empty() ? "" : " and ",
                        format_quantity(height, Dimension::kLength), 2 + axis);
  }
  return text;
}

}  // namespace

std::optional<Warning> image_shift_warning(const Task& task) {
  if (is_parabola(task.mirror) || task.trace.centre == Centre::kCentroid) return std::nullopt;
  const std::array<double, 2> centroid = centroid_of_rays(task);
  const double shift = std::hypot(centroid[0], centroid[1]);
  // Radii about a point at `shift` from the centre of a round spot are larger by less than (shift/radius)^2.
  // The smallest possible ee50 is that of the perfect mirror, 0.5349 lambda f/D for a full circle.
  const double smallest =
      0.5349 * task.wavelength * task.mirror.focal_length / (2 * aperture_radius(task.aperture));
  if (!(std::pow(shift / smallest, 2) > task.equivalence.margin)) return std::nullopt;
  const std::string effect = effect_on_radii(task);
  if (effect.empty()) return std::nullopt;
  return Warning{
      "image-off-axis",
      fmt::format(
          "the known aberrations move the image: its centroid is {} from the nominal focus, which is the "
          "centre of radii, rings and squares ({}). To centre it, tilt the mirror as one points a telescope: "
          "add {} in `mirror.zernike` (heights of the surface); `trace.centre` \"centroid\" is for rays only",
          format_quantity(shift, Dimension::kLength), effect, centring_tilt(task, centroid))};
}

}  // namespace aberfit
