#include "aberfit/spectrum/surface_psd.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/root.h"
#include "aberfit/roughness/k_correlation.h"

namespace aberfit {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr double kLargestFactor = 2;
// Least 2-D exponent. At 1 the profile PSD diverges; the margin keeps 1/(exponent - 1) moderate.
constexpr double kLeastExponent = 1.05;

// int_a^b f^power df
double power_integral(double power, double a, double b) {
  const double p = power + 1, log_ratio = std::log(b / a);
  return std::pow(a, p) * (std::abs(p * log_ratio) < 1e-9 ? log_ratio : std::expm1(p * log_ratio) / p);
}

// Returns exponents -d log S/d log f of the decade about each bin, by least squares weighted by degrees of
// freedom (if any); 0 if fewer than three bins have a level.
ArrayXd fall_of(const SurfacePsd& surface, const ArrayXd& s) {
  constexpr double kHalfADecade = 1.15;  // of log f
  const ArrayXd log_f = surface.frequency.log();
  ArrayXd exponent = ArrayXd::Zero(log_f.size());
  for (Index b = 0; b < log_f.size(); ++b) {
    double count = 0, n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (Index c = 0; c < log_f.size(); ++c) {
      const double u = log_f[c] - log_f[b];
      if (std::abs(u) > kHalfADecade || !(s[c] > 0)) continue;
      const double w = surface.dof.size() > 0 ? surface.dof[c] : 1, v = std::log(s[c]);
      ++count, n += w, x += w * u, y += w * v, xx += w * u * u, xy += w * u * v;
    }
    const double spread = n * xx - x * x;
    if (count >= 3 && spread > 0) exponent[b] = -(n * xy - x * y) / spread;
  }
  return exponent;
}

}  // namespace

SurfacePsd surface_psd(const PsdEstimate& estimate, const PsdModelFit& fit) {
  const bool fitted = fit.spectrum.size() == estimate.psd.size();
  const ArrayXd model = fitted ? fit.spectrum : ArrayXd::Constant(estimate.psd.size(), NAN);
  const ArrayXd factor =
      fitted ? ArrayXd(fit.spectrum / fit.expected) : ArrayXd(1 / estimate.response.rowwise().sum().array());
  std::vector<Index> bins;
  for (Index b = 0; b < factor.size(); ++b)
    if (factor[b] <= kLargestFactor && factor[b] >= 1 / kLargestFactor &&
        estimate.frequency[b] >= std::min(estimate.trusted_from, fit.f_min) &&
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
          bins,
          fitted ? fit.f_min : 0,
          fitted ? fit.f_max : kInfinity};
}

BandRms rms_in_band(const SurfacePsd& surface, PsdTableKind kind, bool of_model, double f_min, double f_max) {
  const bool profile = kind == PsdTableKind::k1dOneSided;
  const ArrayXd& s = of_model ? surface.model : surface.psd;
  const ArrayXd exponent = fall_of(surface, s);
  double height = 0, slope = 0, counted_to = f_min;
  for (Index b = 0; b < surface.psd.size(); ++b) {
    const double f = surface.frequency[b];
    const double from = std::max(counted_to, surface.low[b]), to = std::min(surface.high[b], f_max);
    if (!(from < to)) continue;
    counted_to = to;
    // psd at f, falling as f^-exponent; d2f = 2 pi f df.
    const double level = s[b] * (profile ? 1 : 2 * kPi);
    const double power = (profile ? 0 : 1) - exponent[b];
    height += level * std::pow(f, exponent[b]) * power_integral(power, from, to);
    slope += level * std::pow(f, exponent[b]) * std::pow(2 * kPi, 2) * power_integral(power + 2, from, to);
  }
  if (!profile) slope *= 0.5;  // one axis
  return {std::sqrt(height), std::sqrt(slope)};
}

BandContent band_content(const SurfacePsd& surface, PsdTableKind kind, const FrequencyBand& band) {
  BandContent content{band, 0, 0, {}, {}};
  const double low = std::max(band.f_min, surface.f_min), high = std::min(band.f_max, surface.f_max);
  for (Index b = 0; b < surface.psd.size(); ++b) {
    const double from = std::max(low, surface.low[b]), to = std::min(high, surface.high[b]);
    if (!(from < to)) continue;
    if (content.to == 0) content.from = from;
    content.to = std::max(content.to, to);
  }
  content.data = rms_in_band(surface, kind, false, low, high);
  content.model = rms_in_band(surface, kind, true, low, high);
  return content;
}

std::vector<BandContent> octaves(const SurfacePsd& surface, PsdTableKind kind) {
  std::vector<BandContent> all;
  if (surface.psd.size() == 0) return all;
  const double low = surface.low.minCoeff(), high = surface.high.maxCoeff();
  for (double f = std::exp2(std::floor(std::log2(low))); f < high; f *= 2) {
    const BandContent octave = band_content(surface, kind, {"", f, 2 * f});
    if (octave.to > 0) all.push_back(octave);
  }
  return all;
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
  // A power law is a k-correlation far above its knee; with B = 1 m the amplitudes are the levels.
  const KCorrelation1d profile = k_correlation_2d_to_1d({amplitude, 1, exponent});
  line.exponent = profile.exponent;
  line.amplitude = profile.amplitude;
  const SurfacePsd surface = surface_psd(estimate, fit);
  line.factor = rms_in_band(surface, estimate.kind, true, f_min, f_max).height /
                rms_in_band(surface, estimate.kind, false, f_min, f_max).height;
  line.describes = fit.goodness >= kPoorFit;
  return line;
}

DrawingLine line_as_measured(const SurfacePsd& surface, PsdTableKind kind, double f_min, double f_max) {
  constexpr double kSteepest = 14;  // two-dimensional
  const bool profile = kind == PsdTableKind::k1dOneSided;
  DrawingLine line;
  line.exponent = NAN;
  line.f_min = f_min, line.f_max = f_max;
  if (surface.psd.size() == 0) return line;
  const BandRms data = rms_in_band(surface, kind, false, f_min, f_max);
  const double from = std::max(f_min, surface.low[0]),
               to = std::min(f_max, surface.high[surface.high.size() - 1]);
  if (!(from < to) || !(data.height > 0)) return line;
  line.f_min = from, line.f_max = to;  // range of the bins
  // Exponents in the integrals are one higher than that of the 2-D PSD: profiles have an exponent one less,
  // and maps have d2f = 2 pi f df. Mean squares are taken up to their common level.
  const double per_slope = std::pow(2 * kPi, 2) * (profile ? 1 : 0.5);
  const auto height = [&](double exponent) { return power_integral(1 - exponent, from, to); };
  const auto off = [&](double exponent) {
    return std::log(per_slope * power_integral(3 - exponent, from, to) / height(exponent)) -
           2 * std::log(data.slope / data.height);
  };
  const double shallow = off(kLeastExponent), steep = off(kSteepest);
  if (!(shallow > 0 && steep < 0)) return line;
  const double exponent = root_between(off, kLeastExponent, kSteepest, shallow, steep);
  const double level =
      std::pow(data.height, 2) / height(exponent);  // level of the profile, or 2 pi times that of S
  const KCorrelation1d of_level = k_correlation_2d_to_1d({profile ? 1.0 : level / (2 * kPi), 1, exponent});
  line.exponent = of_level.exponent;
  line.amplitude = profile ? level : of_level.amplitude;
  return line;
}

}  // namespace aberfit
