#include "diffraction_otf.h"

#include <algorithm>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <numbers>

namespace aberfit {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

// In double, not by way of long double: 1e-16 absolute is enough for sums of thousands.
using Policy = boost::math::policies::policy<boost::math::policies::promote_double<false>>;
double bessel(int order, double x) { return boost::math::cyl_bessel_j(order, x, Policy()); }

}  // namespace

Eigen::ArrayXd RadialOtf::energy_weights(double q, Eigen::Index nodes) {
  Eigen::ArrayXd weights(nodes);
  weights[0] = std::numbers::pi * q * q;
  for (Eigen::Index j = 1; j < nodes; ++j) {
    const double s = double(j) / kNodesPerLag;
    weights[j] = q * bessel(1, kTwoPi * q * s) / s;
  }
  return weights;
}

double RadialOtf::energy(double q) const { return (values_ * energy_weights(q, values_.size())).sum(); }

double RadialOtf::density(double q) const {
  double sum = 0;
  for (Eigen::Index j = 0; j < values_.size(); ++j)
    sum += values_[j] * bessel(0, kTwoPi * q * double(j) / kNodesPerLag);
  return kTwoPi * q * sum;
}

std::optional<double> RadialOtf::radius(double fraction, double q_max) const {
  // Energy grows with q, so the first crossing of a scan is the only one. Steps grow with q: few far from the
  // core.
  double low = 0, f_low = -fraction, high = 2.0 / double(values_.size()), f_high = energy(high) - fraction;
  while (f_high < 0) {
    if (high >= q_max) return std::nullopt;
    low = high;
    f_low = f_high;
    high = std::min(2 * high, q_max);
    f_high = energy(high) - fraction;
  }
  // Newton from the end that is nearer in energy, kept inside the bracket.
  double q = low + (high - low) * (-f_low) / (f_high - f_low);
  for (int iteration = 0; iteration < 100; ++iteration) {
    const double f = energy(q) - fraction;
    if (f == 0) return q;
    (f < 0 ? low : high) = q;
    const double slope = density(q);
    double next = slope > 0 ? q - f / slope : low;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - q) <= 4e-15 * q) return next;
    q = next;
  }
  return q;
}

}  // namespace aberfit
