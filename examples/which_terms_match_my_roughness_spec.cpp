// Which aberration terms match my roughness specification? The whole path of `aberfit fit` from a program:
// a study as text, the fit by waves that this mirror needs, and the verdict on a grid it has not seen.
#include <fmt/format.h>

#include "aberfit/aberfit.h"

int main() {
  const aberfit::Study study = aberfit::parse_study(R"({
    "aberfit": 1,
    "mirror": { "focal_length": "2.8 m" },
    "aperture": { "shape": "circle", "diameter": "0.4 m" },
    "light": { "wavelength": "632.8 nm" },
    "roughness": { "psd": { "model": "uniform", "rms": "100 nm", "f_min": "2.5 /m", "f_max": "19.96 /m" } },
    "terms": { "zernike": { "n_max": 28 } },
    "equivalence": { "margin": "1 %" }
  })",
                                                    "my_spec.json");
  const aberfit::ResultDocument result = aberfit::run_fit(study, {});

  fmt::print("{}: {}\n", aberfit::to_string(result.fit.status), result.fit.message);
  for (std::size_t k = 0; k < result.targets.size(); ++k) {
    const std::string name = aberfit::statistic_name(result.targets[k].statistic);
    if (name != "ee90_radius_m" && name != "ring_fwhm_m" && name != "rms_height_m") continue;
    const Eigen::Index at = Eigen::Index(k);
    fmt::print("{}: target {:.5g}, a draw of the roughness {:.4g}, these terms {:.4g}\n", name,
               result.targets[k].value, result.start[at], result.fitted[at]);
  }
  fmt::print("verdict on a finer grid and held-out statistics: {}\n", aberfit::to_string(result.verdict));
  fmt::print("the first of {} coefficients:\n", result.fit.coefficients.size());
  for (std::size_t j = 0; j < 5; ++j)
    fmt::print("  Z({}, {:2}) {:8.2f} nm +- {:.2f}\n", result.terms.zernike[j].n, result.terms.zernike[j].m,
               1e9 * result.fit.coefficients[Eigen::Index(j)],
               1e9 * result.fit.coefficient_std[Eigen::Index(j)]);
}
