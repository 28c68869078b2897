// How wide is the focus of a rough mirror? Geometric Harvey-Shack theory answers without tracing a ray, here
// for a 0.4 m parabola of f = 2.8 m with 100 nm RMS between 2.5 and 19.96 cycles/m.
#include <fmt/format.h>

#include "aberfit/roughness/psd.h"
#include "aberfit/theory/geometric_harvey_shack.h"

int main() {
  const aberfit::Mirror mirror{.focal_length = 2.8};
  const aberfit::Aperture aperture = aberfit::CircleAperture{.diameter = 0.4};
  const aberfit::UniformPsd polish{.rms = 100e-9, .f_min = 2.5, .f_max = 19.96};  // [m], [cycles/m]

  // Geometric theory needs only the standard deviation of the slope along one axis.
  const aberfit::PsdMoments moments = aberfit::psd_moments(aberfit::RadialPsd(polish));
  const double slope = moments.rms_slope_per_axis();
  const aberfit::GeometricHarveyShack focus(mirror, aperture, slope, aberfit::Convention::kPhysical,
                                            moments.rms_height());

  const double ee90 = focus.encircled_energy_radius(0.9, 0);
  fmt::print("RMS slope per axis        {:.4f} urad\n", 1e6 * slope);
  fmt::print("half the light within     {:.3f} um\n", 1e6 * focus.encircled_energy_radius(0.5, 0));
  fmt::print("90 % of the light within  {:.3f} um\n", 1e6 * ee90);
  fmt::print("1 mm before the focus     {:.3f} um\n", 1e6 * focus.encircled_energy_radius(0.9, -1e-3));
  fmt::print("RMS scatter angle         {:.4f} urad\n", 1e6 * focus.scatter_rms());
  fmt::print("depth of the 90 % ring    {:.4f} mm (full width at half maximum)\n",
             1e3 * focus.ring_fwhm(ee90));
}
