#include <cmath>
#include <numbers>

#include "aberfit/terms/derivatives.h"
#include "aberfit/terms/surface_operator.h"
#include "zernike_derivative.h"

namespace aberfit {
using namespace internal;

Eigen::ArrayXd cross_derivative(const TermSet& terms, const Eigen::VectorXd& coefficients,
                                const Eigen::ArrayXd& x, const Eigen::ArrayXd& y) {
  const SurfaceOperator given(terms, x, y);  // throws for an invalid term set; costs no evaluation
  // dh/dy consists of terms of the same kinds; we need its slope along x. Spherical terms have a closed form.
  TermSet along_y;
  along_y.radius = terms.radius;
  along_y.fourier = terms.fourier;
  ZernikeExpansion derivative;
  if (!terms.zernike.empty())
    derivative =
        zernike_derivative_along_y({terms.zernike, coefficients.head(Eigen::Index(terms.zernike.size()))});
  along_y.zernike = derivative.modes;
  Eigen::VectorXd c(along_y.size());
  if (!along_y.zernike.empty())
    c.head(Eigen::Index(along_y.zernike.size())) = derivative.coefficients / terms.radius;
  for (std::size_t k = 0; k < terms.fourier.size(); ++k) {
    const Eigen::Index from = terms.fourier_begin() + 2 * Eigen::Index(k);
    const Eigen::Index to = along_y.fourier_begin() + 2 * Eigen::Index(k);
    const double wave_number = 2 * std::numbers::pi * terms.fourier[k].fy;
    c[to] = wave_number * coefficients[from + 1];
    c[to + 1] = -wave_number * coefficients[from];
  }
  SurfaceField field;
  SurfaceOperator(along_y, x, y).apply(c, &field);
  Eigen::ArrayXd result = field.slope_x;
  for (std::size_t k = 0; k < terms.spherical.size(); ++k) {
    // d2/dxdy of rho^p = p (p - 2) x y rho^(p-4) / radius^4.
    const int p = terms.spherical[k];
    const double factor =
        coefficients[terms.spherical_begin() + Eigen::Index(k)] * p * (p - 2) / std::pow(terms.radius, 4);
    result += factor * x * y * ((x.square() + y.square()) / (terms.radius * terms.radius)).pow((p - 4) / 2);
  }
  return result;
}

}  // namespace aberfit
