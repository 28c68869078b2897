#include "aberfit/roughness/k_correlation.h"

#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "aberfit/roughness/psd_integrals.h"

namespace aberfit {
namespace {

// Ratio of the 2-D amplitude to the 1-D amplitude times B; C: 1-D exponent.
double abel_constant(double C) {
  return std::exp(boost::math::lgamma(0.5 * (C + 1)) - boost::math::lgamma(0.5 * C)) /
         (2 * std::sqrt(std::numbers::pi));
}

}  // namespace

KCorrelation2d k_correlation_1d_to_2d(const KCorrelation1d& profile) {
  if (!(profile.exponent > 0))
    throw std::domain_error("the 1-D exponent of a k-correlation PSD must be positive");
  return {profile.amplitude * profile.correlation * abel_constant(profile.exponent), profile.correlation,
          profile.exponent + 1};
}

KCorrelation1d k_correlation_2d_to_1d(const KCorrelation2d& surface) {
  if (!(surface.exponent > 1))
    throw std::domain_error("the 2-D exponent of a k-correlation PSD must exceed 1");
  const double exponent = surface.exponent - 1;
  return {surface.amplitude / (surface.correlation * abel_constant(exponent)), surface.correlation, exponent};
}

KCorrelationPsd k_correlation_model(const KCorrelation2d& surface, double f_min, double f_max) {
  KCorrelationPsd model{1.0, surface.correlation, surface.exponent, f_min, f_max};
  const std::string problem = psd_problem(model);
  if (!problem.empty()) throw std::domain_error(problem);
  // The amplitude of unit RMS, evaluated at f_min, where the shape is largest in the band.
  const double shape =
      std::exp(-0.5 * surface.exponent * std::log1p(std::pow(surface.correlation * f_min, 2)));
  model.rms = std::sqrt(surface.amplitude * shape / RadialPsd(model)(f_min));
  return model;
}

}  // namespace aberfit
