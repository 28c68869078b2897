#include "aberfit/theory/paper_table.h"

#include <cmath>
#include <numbers>

#include "aberfit/theory/model_choice.h"

namespace aberfit {
namespace {

PaperCell paper_cell(double sigma, double l_c, double diameter, double wavelength, const Mirror& mirror) {
  // int exp(-(r/l)^2) dr = sqrt(pi)/2 l
  const RadialPsd psd(GaussianPsd{sigma, 2 * l_c / std::sqrt(std::numbers::pi)});
  const Aperture aperture = CircleAperture{diameter};
  const SceneNumbers n = scene_numbers(psd, mirror, aperture, wavelength);
  const ModelChoice choice = choose_model(psd, mirror, aperture, wavelength);
  return {sigma, l_c, diameter, n.paper_ratio_r, n.g, n.kappa, choice.errors.ray_ee90, choice.model};
}

}  // namespace

std::string paper_verdict(double ratio) {
  return ratio >= kPaperRatioForRays ? "rays" : ratio < 1 ? "waves" : "unclear";
}

PaperCells paper_cells(const PaperTable& ranges, double focal_length) {
  const Mirror mirror{focal_length, -1, {}};
  PaperCells table{ranges.wavelength, {}};
  for (const double diameter : ranges.diameters)
    for (const double sigma : ranges.rms_heights)
      for (const double l_c : ranges.correlation_lengths)
        table.cells.push_back(paper_cell(sigma, l_c, diameter, ranges.wavelength, mirror));
  return table;
}

}  // namespace aberfit
