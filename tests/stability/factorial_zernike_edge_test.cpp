// Compares Zernikes from the textbook sum with factorials in double precision with the program's recurrences.
// The truth is the same sum in 200 digits (terms/zernike_exact.h). The points have rho >= 0.99, where the sum
// cancels most; at mid-pupil it looks right until n = 50.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "aberfit/scene/zernike.h"
#include "aberfit/terms/surface_operator.h"
#include "edge.h"
#include "terms/zernike_exact.h"

namespace aberfit::test {
namespace {

constexpr double kOverflow = std::numeric_limits<double>::infinity();  // of factorials, from n = 171 on
constexpr double kRim[] = {0.99, 0.995, 0.999, 1.0};

// The sum as many programs compute it: doubles, factorials by the gamma function.
double factorial_radial(int n, double rho, bool derivative) {
  double sum = 0;
  for (int s = 0; s <= n / 2; ++s) {
    const int power = n - 2 * s;
    const double c = (s % 2 ? -1 : 1) * std::tgamma(n - s + 1.0) /
                     (std::tgamma(s + 1.0) * std::tgamma(n / 2 - s + 1.0) * std::tgamma(n / 2 - s + 1.0));
    if (!derivative) sum += c * std::pow(rho, power);
    if (derivative && power > 0) sum += c * power * std::pow(rho, power - 1);
  }
  return std::sqrt(n + 1.0) * sum;
}

struct Errors {
  double ours = 0, factorial = 0;
};

// Largest error over the rim of Z_n^0, relative to the largest value (or gradient) of the mode over the disc,
// which is at the rim: sqrt(n + 1), and n (n + 2)/2 times that for the gradient (R_n^0'(1) = n (n + 2)/2).
Errors errors_of(int n, bool gradient) {
  const zernike_exact::Radial exact = zernike_exact::radial({n, 0});
  const double largest = std::sqrt(n + 1.0) * (gradient ? n * (n + 2) / 2.0 : 1.0);
  TermSet terms;
  terms.radius = 1;
  terms.zernike = {{n, 0}};
  Errors errors;
  for (const double rho : kRim) {
    const zernike_exact::Value truth = zernike_exact::evaluate(exact, zernike_exact::Point(rho, 0, 0));
    const double value = double(gradient ? truth.dx : truth.value);
    const ZernikeValue plain = zernike({n, 0}, rho, 0);
    SurfaceField field;  // the fast kernel
    SurfaceOperator(terms, Eigen::ArrayXd::Constant(1, rho), Eigen::ArrayXd::Zero(1))
        .apply(Eigen::VectorXd::Ones(1), &field);
    for (const double found :
         {gradient ? plain.dx : plain.value, gradient ? field.slope_x[0] : field.height[0]})
      errors.ours = std::max(errors.ours, std::abs(found - value) / largest);
    const double factorial = std::abs(factorial_radial(n, rho, gradient) - value) / largest;
    if (!(factorial <= errors.factorial)) errors.factorial = std::isnan(factorial) ? kOverflow : factorial;
  }
  return errors;
}

void sweep(const char* name, bool gradient, double from, double to, double constant) {
  Edge edge(name, "radial order n of the Zernike [1]",
            gradient ? "gradient error / largest gradient [1]" : "height error / largest height [1]");
  edge.linear_parameter();
  for (int n = 4; n <= 300; n += n < 60 ? 4 : 30) {
    const Errors errors = errors_of(n, gradient);
    edge.add({double(n), errors.ours, n <= 100 ? 1e-12 : 1e-11, false, errors.factorial});  // zernike.h
  }
  // Terms of the sum grow as (1 + sqrt 2)^n, and their rounding remains.
  edge.follows({gradient ? "slope: 1e-18 (1+sqrt2)^n" : "height: 1e-17 (1+sqrt2)^n",
                [constant](double n) { return constant * std::pow(1 + std::numbers::sqrt2, n); }, from, to,
                10});
  edge.expect();
}

TEST(StabilityEdge, FactorialZernikesInHeight) { sweep("factorial_zernike_height", false, 12, 48, 1e-17); }
TEST(StabilityEdge, FactorialZernikesInSlope) { sweep("factorial_zernike_slope", true, 12, 48, 1e-18); }

}  // namespace
}  // namespace aberfit::test
