#include <boost/math/special_functions/bessel.hpp>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/roughness/psd_integrals.h"
#include "hankel_panels.h"

namespace aberfit {
using namespace internal;

namespace {

// Any S with a finite height variance; r > 0.
double by_quadrature(const SharedPanels& shared, double r) {
  const double k = 2 * kPi * r;
  double sum = shared.low_variance;
  for (const PsdPanel& panel : shared.panels) {
    if (k * panel.a <
        // One octave: the argument of J0 spans 30 rad at most, and 24 nodes resolve it to 1e-19 (j_48(15)).
        kHankelFrom) {
      for (int j = 0; j < kPanelNodes; ++j)
        sum += 2 * kPi * panel.weight[j] * panel.psd[j] * panel.f[j] *
               boost::math::cyl_bessel_j(0, k * panel.f[j]);
      continue;
    }
    const auto weights = oscillatory_weights(panel.a, panel.b, k);
    std::complex<double> total = 0;
    for (int j = 0; j < kPanelNodes; ++j) {
      const double x = k * panel.f[j];
      total += weights[j] * hankel_amplitudes(x).h0 * (panel.psd[j] * panel.f[j] * std::sqrt(2 / (kPi * x)));
    }
    sum += 2 * kPi * (total * std::polar(1.0, -0.25 * kPi)).real();
  }
  return sum;
}

}  // namespace

Eigen::ArrayXd autocorrelation(const RadialPsd& psd, const Eigen::ArrayXd& r) {
  if (!has_finite_height_variance(psd)) return Eigen::ArrayXd::Constant(r.size(), kInfinity);
  Eigen::ArrayXd result = Eigen::ArrayXd::Zero(r.size());
  if ((r <= 0).any()) result = (r <= 0).select(radial_moment(psd, 0), result);
  const Eigen::ArrayXd positive = (r > 0).select(r, kInfinity);
  const double r_max = r.size() > 0 ? r.maxCoeff() : 0;
  if (r_max <= 0) return result;
  const SharedPanels shared = shared_panels(psd, positive.minCoeff(), r_max);
  for (Eigen::Index i = 0; i < r.size(); ++i)
    if (r[i] > 0) result[i] = by_quadrature(shared, r[i]);
  return result;
}

double autocorrelation(const RadialPsd& psd, double r) {
  return autocorrelation(psd, Eigen::ArrayXd::Constant(1, r))[0];
}

}  // namespace aberfit
