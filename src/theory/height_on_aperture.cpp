#include "aberfit/theory/height_on_aperture.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/psd_derivative.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/theory/aperture_otf.h"

namespace aberfit {
namespace {

constexpr double kCycles = 24;  // above it the aperture's mean is below 6e-6 of a wave's variance
constexpr int kNodesPerCycle = 16;

// Mean square over the aperture of waves below kCycles across, by half their structure function.
double mean_square(const Aperture& aperture, const ApertureOtf& otf,
                   const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& half_structure) {
  // Panels between the shears where the overlap is not smooth, a cycle each.
  std::vector<double> shear, weight;
  double from = 0;
  for (const double to : otf.breakpoints()) {
    const int panels = std::max(1, int(std::ceil((to - from) / otf.cutoff() * kCycles)));
    for (int p = 0; p < panels; ++p) {
      const double width = (to - from) / panels;
      const Quadrature rule = gauss_legendre(kNodesPerCycle, from + p * width, from + (p + 1) * width);
      shear.insert(shear.end(), rule.nodes.data(), rule.nodes.data() + rule.nodes.size());
      weight.insert(weight.end(), rule.weights.data(), rule.weights.data() + rule.weights.size());
    }
    from = to;
  }
  const Eigen::ArrayXd s = Eigen::Map<const Eigen::ArrayXd>(shear.data(), Eigen::Index(shear.size()));
  const Eigen::ArrayXd less = half_structure(s);
  double sum = 0;
  for (Eigen::Index i = 0; i < s.size(); ++i)
    sum += weight[std::size_t(i)] * less[i] * otf(s[i]) * kTwoPi * s[i];
  return sum / aperture_area(aperture);
}

}  // namespace

double rms_height_on(const Aperture& aperture, const RadialPsd& psd) {
  const ApertureOtf otf(aperture);
  const double high = std::max(kCycles / otf.cutoff(), psd.f_min());
  const double fine = high < psd.f_max() ? radial_moment(psd, 0, high) : 0;
  if (!std::isfinite(fine) || !(psd.f_min() < high)) return std::sqrt(fine);
  const RadialPsd coarse = psd.band(0, high);
  return std::sqrt(
      mean_square(aperture, otf, [&](const Eigen::ArrayXd& s) { return structure_function(coarse, s); }) +
      fine);
}

double height_variance_change_on(const Aperture& aperture, const RadialPsd& psd,
                                 const PsdDerivative& derivative) {
  const ApertureOtf otf(aperture);
  const double high = std::max(kCycles / otf.cutoff(), psd.f_min());
  const double above = std::nextafter(high, kInfinity);  // a delta ring at `high` counts once
  const double fine = high < psd.f_max() ? derivative.moment(0, psd.f_min() < high ? above : high) : 0;
  if (!std::isfinite(fine) || !(psd.f_min() < high)) return fine;
  const PsdDerivative coarse = derivative.band(0, high);
  return mean_square(aperture, otf, [&](const Eigen::ArrayXd& s) { return coarse.structure_function(s); }) +
         fine;
}

}  // namespace aberfit
