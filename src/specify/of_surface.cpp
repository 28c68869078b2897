#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/overloaded.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/specify/budget.h"

namespace aberfit {

namespace {

double half_structure(const RadialPsd& psd, const HeightDifference& difference) {
  return structure_function(psd, Eigen::ArrayXd::Constant(1, difference.separation))[0];
}

// Returns d ln(sqrt(square))/dp.
double of_root(double change, double square) {
  return square > 0 && std::isfinite(square) ? change / (2 * square) : kNaN;
}

}  // namespace

double of_surface(const OfSurface& what, const RadialPsd& psd) {
  return std::visit(
      Overloaded{
          [&](const HeightInBand& band) { return std::sqrt(radial_moment(psd, 0, band.f_min, band.f_max)); },
          // Half of (2 pi f)^2 for one axis.
          [&](const SlopeInBand& band) {
            return 2 * kPi * std::sqrt(0.5 * radial_moment(psd, 2, band.f_min, band.f_max));
          },
          [&](const HeightDifference& difference) { return std::sqrt(2 * half_structure(psd, difference)); }},
      what);
}

double of_surface_change(const OfSurface& what, const RadialPsd& psd, const PsdDerivative& derivative) {
  const auto of_moment = [&](double power, double a, double b) {
    return of_root(derivative.moment(power, a, b), radial_moment(psd, power, a, b));
  };
  return std::visit(Overloaded{[&](const HeightInBand& band) { return of_moment(0, band.f_min, band.f_max); },
                               [&](const SlopeInBand& band) { return of_moment(2, band.f_min, band.f_max); },
                               [&](const HeightDifference& difference) {
                                 const double change = derivative.structure_function(
                                     Eigen::ArrayXd::Constant(1, difference.separation))[0];
                                 return of_root(change, half_structure(psd, difference));
                               }},
                    what);
}

}  // namespace aberfit
