#include "zernike_derivative.h"

#include <algorithm>
#include <cstdlib>

#include "aberfit/scene/zernike.h"

namespace aberfit::internal {

ZernikeExpansion zernike_derivative_along_y(const ZernikeExpansion& expansion) {
  int top = 0;
  for (const ZernikeMode& mode : expansion.modes) top = std::max(top, mode.n);
  // Peak-normalised coefficients a_n^m, with m > 0 the real part (cosine) and m < 0 the imaginary part (sine)
  // of V, summed over n, n + 2, ... They are the factors of the order n - 1 of the derivative.
  const auto place = [](int n, int m) { return Eigen::Index((n * (n + 2) + m) / 2); };
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(place(top, top) + 1);
  for (std::size_t j = 0; j < expansion.modes.size(); ++j) {
    const ZernikeMode mode = expansion.modes[j];
    sum[place(mode.n, mode.m)] += zernike_norm(mode) * expansion.coefficients[Eigen::Index(j)];
  }
  for (int n = top - 2; n >= 0; --n)
    for (int m = -n; m <= n; m += 2) sum[place(n, m)] += sum[place(n + 2, m)];
  ZernikeExpansion result;
  result.modes = zernike_modes(0, top - 1);
  result.coefficients.resize(Eigen::Index(result.modes.size()));
  for (std::size_t j = 0; j < result.modes.size(); ++j) {
    const auto [n, m] = result.modes[j];
    const int k = std::abs(m);
    const auto above = [&, order = n](int angular) { return sum[place(order + 1, angular)]; };
    // Contributions to angular order k: from k + 1 by its m - 1, and from k - 1 by its m + 1. V^-1 is the
    // conjugate of V^1, so order 0 contributes twice to order 1.
    double value = 0;
    if (m >= 0) {  // the factor i turns sines into cosines
      value = above(-(k + 1));
      if (k > 1) value -= above(-(k - 1));
    } else {
      value = -above(k + 1) + (k > 1 ? above(k - 1) : 2 * above(0));
    }
    result.coefficients[Eigen::Index(j)] = (n + 1) * value / zernike_norm(result.modes[j]);
  }
  return result;
}

}  // namespace aberfit::internal
