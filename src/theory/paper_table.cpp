#include "aberfit/theory/paper_table.h"

#include <algorithm>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <numbers>

#include "aberfit/theory/model_choice.h"

namespace aberfit {
namespace {

PaperCell paper_cell(double sigma, double l_c, double diameter, double wavelength, const Mirror& mirror) {
  const double length = 2 * l_c / std::sqrt(std::numbers::pi);  // int exp(-(r/l)^2) dr = sqrt(pi)/2 l
  const RadialPsd psd(GaussianPsd{sigma, length});
  const Aperture aperture = CircleAperture{diameter};
  const SceneNumbers n = scene_numbers(psd, mirror, aperture, wavelength);
  const ModelChoice choice = choose_model(psd, mirror, aperture, wavelength, kUsualAllowedError);
  return {sigma,
          l_c,
          diameter,
          n.paper_ratio_r,
          n.g,
          n.kappa,
          choice.errors.ray_ee90,
          choice.model,
          gaussian_share_beyond(sigma, length, wavelength, kSmallAngle)};
}

}  // namespace

double gaussian_share_beyond(double sigma, double length, double wavelength, double angle) {
  const double g2 = std::pow(4 * std::numbers::pi * sigma / wavelength, 2);
  const double spread = std::pow(std::numbers::pi * length * std::sin(angle) / wavelength, 2);
  // Poisson weights beyond this many standard deviations are below 1e-16 of the sum.
  constexpr double kDeviations = 9;
  const double reach = kDeviations * std::sqrt(g2) + kDeviations * kDeviations;
  double share = 0;
  for (double n = std::max(1.0, std::floor(g2 - reach)); n <= g2 + reach; ++n)
    share += std::exp(n * std::log(g2) - g2 - boost::math::lgamma(n + 1) - spread / n);
  return share;
}

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
