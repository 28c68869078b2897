// Are rays valid for my scene, or does it need wave optics? This program looks at one polish in three
// colours. Rays are valid if the structure function is nearly quadratic where it matters (kappa); the size of
// R or sigma does not decide.
#include <fmt/format.h>

#include "aberfit/theory/regime.h"

int main() {
  const aberfit::Mirror mirror{.focal_length = 2.8};
  const aberfit::Aperture aperture = aberfit::CircleAperture{.diameter = 0.4};
  const aberfit::RadialPsd psd(aberfit::UniformPsd{.rms = 100e-9, .f_min = 2.5, .f_max = 19.96});

  for (const double wavelength : {632.8e-9, 1.55e-6, 10.6e-6}) {
    const aberfit::SceneNumbers scene = aberfit::scene_numbers(psd, mirror, aperture, wavelength);
    fmt::print("wavelength {:.1f} nm: rays are {}\n", 1e9 * wavelength,
               scene.kappa_rule_allows_rays ? "valid" : "not valid");
    fmt::print("  g {:.5f}, scattered share {:.5f}, kappa {:.5f}, R {:.3f}\n", scene.g, scene.tis,
               scene.kappa, scene.paper_ratio_r);
    fmt::print("  {}\n", scene.reason);
  }
}
