#include <algorithm>
#include <cassert>
#include <cmath>

#include "aberfit/core/errors.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/terms/modal_covariance.h"
#include "zernike_integrals.h"

namespace aberfit {
using namespace internal;

Eigen::MatrixXd zernike_covariance(const RadialPsd& psd, double radius, int m,
                                   const std::vector<int>& n_values) {
  assert(std::is_sorted(n_values.begin(), n_values.end()));
  if (n_values.empty()) return {};
  std::vector<int> places;  // rows in the table
  for (const int n : n_values) {
    assert(n >= std::abs(m) && (n - m) % 2 == 0);
    places.push_back(n - n_values.front());
  }
  (void)m;  // m only determines which n are allowed
  return zernike_covariance_table(psd, radius, n_values.front(), n_values.back())(places, places);
}

namespace {

double finite_height_variance(const RadialPsd& psd) {
  const double variance = radial_moment(psd, 0);
  if (!std::isfinite(variance) || variance == 0)
    throw ComputationError(
        "a fraction of the height variance needs a PSD whose height variance is finite and not zero");
  return variance;
}

}  // namespace

double captured_fraction(const RadialPsd& psd, double radius, int n_min, int n_max) {
  const double total = finite_height_variance(psd);
  if (n_max < n_min) return 0;
  const Eigen::ArrayXd variances = zernike_variances(psd, radius, n_min, n_max);
  double sum = 0;
  for (int n = n_min; n <= n_max; ++n) sum += (n + 1) * variances[n - n_min];  // n + 1 signed m each
  return sum / total;
}

}  // namespace aberfit
