// Which aberration terms match my roughness specification? This program does the same as `aberfit fit`: a
// study, the fit by waves that this mirror needs, and the verdict on a grid that the fit has not seen.
#include <fmt/format.h>

#include "aberfit/aberfit.h"

int main() {
  // Members that are not set keep the defaults of a study file.
  aberfit::Study study;
  study.mirror.focal_length = 2.8;                      // [m]
  study.aperture = aberfit::CircleAperture{0.4};        // [m]
  study.wavelength = 632.8e-9;                          // [m]
  study.psd = aberfit::UniformPsd{100e-9, 2.5, 19.96};  // RMS [m] in a band [cycles/m]
  study.terms.zernike = aberfit::ZernikeSpec{2, 28};    // n = 2 to 28
  const aberfit::ResultDocument result = aberfit::run_fit(study, {});

  fmt::print("{}: {}\n", aberfit::to_string(result.fitted.fit.status), result.fitted.fit.message);
  for (std::size_t k = 0; k < result.fitted.targets.size(); ++k) {
    const std::string name = aberfit::statistic_name(result.fitted.targets[k].statistic);
    if (name != "ee90_radius_m" && name != "ring_fwhm_m" && name != "rms_height_m") continue;
    const Eigen::Index at = Eigen::Index(k);
    fmt::print("{}: target {:.5g}, a draw of the roughness {:.4g}, these terms {:.4g}\n", name,
               result.fitted.targets[k].value, result.fitted.start[at], result.fitted.values[at]);
  }
  fmt::print("verdict on a finer grid and held-out statistics: {}\n",
             aberfit::to_string(result.judgement.verdict));
  fmt::print("the first of {} coefficients:\n", result.fitted.fit.coefficients.size());
  for (std::size_t j = 0; j < 5; ++j)
    fmt::print("  Z({}, {:2}) {:8.2f} nm +- {:.2f}\n", result.fitted.terms.zernike[j].n,
               result.fitted.terms.zernike[j].m, 1e9 * result.fitted.fit.coefficients[Eigen::Index(j)],
               1e9 * result.fitted.fit.coefficient_std[Eigen::Index(j)]);
}
