#include "aberfit/spectrum/surface_psd.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/k_correlation.h"

namespace aberfit {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr double kLargestFactor = 2;
// 2-D exponents of surfaces whose profile PSD is finite, with room for the power of 1/(exponent - 1).
constexpr double kLeastExponent = 1.05;

}  // namespace

SurfacePsd surface_psd(const PsdEstimate& estimate, const PsdModelFit& fit) {
  const bool fitted = fit.spectrum.size() == estimate.psd.size();
  const ArrayXd model = fitted ? fit.spectrum : ArrayXd::Constant(estimate.psd.size(), NAN);
  const ArrayXd factor =
      fitted ? ArrayXd(fit.spectrum / fit.expected) : ArrayXd(1 / estimate.response.rowwise().sum().array());
  std::vector<Index> bins;
  for (Index b = 0; b < factor.size(); ++b)
    if (factor[b] <= kLargestFactor && factor[b] >= 1 / kLargestFactor &&
        estimate.frequency[b] <= std::max(estimate.trusted_to, fit.f_max))
      bins.push_back(b);
  const ArrayXd by = factor(bins);
  return {estimate.frequency(bins),
          estimate.low(bins),
          estimate.high(bins),
          estimate.psd(bins) * by,
          estimate.lower(bins) * by,
          estimate.upper(bins) * by,
          estimate.dof(bins),
          model(bins),
          by,
          bins};
}

BandRms rms_in_band(const SurfacePsd& surface, PsdTableKind kind, bool of_model, double f_min, double f_max) {
  double height = 0, slope = 0;
  for (Index b = 0; b < surface.psd.size(); ++b) {
    const double f = surface.frequency[b], low = surface.low[b], high = surface.high[b];
    if (f < f_min || f > f_max) continue;
    const double area = kind == PsdTableKind::k1dOneSided ? high - low : kPi * (high * high - low * low);
    const double variance = (of_model ? surface.model : surface.psd)[b] * area;
    height += variance;
    slope += std::pow(2 * kPi * f, 2) * variance;
  }
  if (kind == PsdTableKind::k2dTwoSided) slope *= 0.5;  // one axis
  return {std::sqrt(height), std::sqrt(slope)};
}

DrawingLine drawing_line(const PsdEstimate& estimate, double f_min, double f_max) {
  PsdFitOptions options;
  options.family = PsdFamily::kPowerLaw;
  options.f_min = f_min, options.f_max = f_max;
  options.confidence = estimate.options.confidence;
  const PsdModelFit fit = fit_psd_model(estimate, options);
  DrawingLine line;
  line.exponent = NAN;
  line.f_min = f_min, line.f_max = f_max;
  line.confidence = options.confidence;
  double exponent = NAN, amplitude = NAN;  // two-dimensional
  for (const PsdParameter& parameter : fit.parameters) {
    if (parameter.name == "exponent") {
      exponent = parameter.value;
      line.exponent_std = parameter.std;
      line.lower = parameter.lower - 1, line.upper = parameter.upper - 1;
    }
    if (parameter.name == "amplitude") {
      amplitude = parameter.value;
      line.log_amplitude_std = parameter.std / parameter.value;
    }
  }
  if (!(exponent > kLeastExponent) || !std::isfinite(amplitude)) return line;
  // A power law is what a k-correlation is far above its knee: with B = 1 m the amplitudes are the levels.
  const KCorrelation1d profile = k_correlation_2d_to_1d({amplitude, 1, exponent});
  line.exponent = profile.exponent;
  line.amplitude = profile.amplitude;
  const SurfacePsd surface = surface_psd(estimate, fit);
  line.factor = rms_in_band(surface, estimate.kind, true, f_min, f_max).height /
                rms_in_band(surface, estimate.kind, false, f_min, f_max).height;
  line.describes = fit.goodness >= kPoorFit;
  return line;
}

}  // namespace aberfit
