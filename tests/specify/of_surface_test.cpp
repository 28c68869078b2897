// Tests quantities of the surface against closed forms and independent integrals.
#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <numbers>

#include "aberfit/specify/budget.h"

namespace aberfit {
namespace {

using std::numbers::pi;
using Kronrod = boost::math::quadrature::gauss_kronrod<double, 61>;

// 2 pi int weight(f) S(f) f df.
template <class Weight>
double integral(const RadialPsd& psd, double a, double b, const Weight& weight) {
  return 2 * pi * Kronrod::integrate([&](double f) { return weight(f) * psd(f) * f; }, a, b, 12, 1e-12);
}

TEST(OfSurface, OfAUniformBandHasItsClosedForms) {
  const RadialPsd psd(UniformPsd{10e-9, 20, 60});
  // The fraction of the area of the annulus in f.
  EXPECT_NEAR(of_surface(HeightInBand{30, 50}, psd) / (10e-9 * std::sqrt(1600.0 / 3200)), 1, 1e-12);
  EXPECT_NEAR(of_surface(HeightInBand{}, psd) / 10e-9, 1, 1e-12);
  EXPECT_EQ(of_surface(HeightInBand{70, 90}, psd), 0);
  // Slope variance per axis: (2 pi)^2 (f_min^2 + f_max^2)/4 times the height variance.
  EXPECT_NEAR(of_surface(SlopeInBand{}, psd) / (pi * 10e-9 * std::sqrt(4000.0)), 1, 1e-12);
  const double part = std::sqrt(1600.0 / 3200) * pi * 10e-9 * std::sqrt(900.0 + 2500);
  EXPECT_NEAR(of_surface(SlopeInBand{30, 50}, psd) / part, 1, 1e-12);
}

TEST(OfSurface, StructureFunctionOfAGaussianIsItsClosedForm) {
  const RadialPsd psd(GaussianPsd{8e-9, 0.01});
  for (const double r : {1e-4, 0.01, 0.2})
    EXPECT_NEAR(
        of_surface(HeightDifference{r}, psd) / (8e-9 * std::sqrt(-2 * std::expm1(-std::pow(r / 0.01, 2)))), 1,
        1e-10)
        << r;
}

TEST(OfSurface, OfAKCorrelationIsTheIntegralOverItsBand) {
  const RadialPsd psd(KCorrelationPsd{17e-9, 0.3, 3.1, 1, 200});
  EXPECT_NEAR(
      of_surface(HeightInBand{2, 37}, psd) / std::sqrt(integral(psd, 2, 37, [](double) { return 1; })), 1,
      1e-10);
  EXPECT_NEAR(of_surface(SlopeInBand{2, 37}, psd) /
                  std::sqrt(integral(psd, 2, 37, [](double f) { return 2 * pi * pi * f * f; })),
              1, 1e-10);
  EXPECT_NEAR(of_surface(HeightDifference{0.04}, psd) /
                  std::sqrt(integral(
                      psd, 1, 200,
                      [](double f) { return 2 * (1 - boost::math::cyl_bessel_j(0, 2 * pi * f * 0.04)); })),
              1, 1e-10);
}

TEST(OfSurface, ItsDerivativesMeetDifferences) {
  const PsdModel model = KCorrelationPsd{17e-9, 0.3, 3.1, 1, 200};
  const OfSurface all[] = {HeightInBand{2, 37}, HeightInBand{2, 500},   SlopeInBand{},
                           SlopeInBand{0.5, 9}, HeightDifference{0.04}, HeightDifference{0.3}};
  for (const PsdVariable& variable : psd_variables(model)) {
    const PsdDerivative derivative(model, variable);
    const double at = value_of(model, variable);
    for (std::size_t i = 0; i < std::size(all); ++i) {
      const auto moved = [&](double by) {
        return std::log(of_surface(all[i], RadialPsd(with_value(model, variable, at * (1 + by)))));
      };
      const double expected = (8 * (moved(3e-4) - moved(-3e-4)) - (moved(6e-4) - moved(-6e-4))) / 36e-4;
      EXPECT_NEAR(of_surface_change(all[i], RadialPsd(model), derivative) * at, expected, 1e-8)
          << i << " over " << pointer_of(variable);
    }
  }
  EXPECT_TRUE(std::isnan(of_surface_change(HeightInBand{300, 400}, RadialPsd(model),
                                           PsdDerivative(model, psd_variables(model).front()))));
}

TEST(OfSurface, AnIntegralThatDoesNotExistIsInfinite) {
  const RadialPsd open(KCorrelationPsd{17e-9, 0.3, 3.1});
  EXPECT_TRUE(std::isinf(of_surface(SlopeInBand{}, open)));
  EXPECT_TRUE(std::isfinite(of_surface(SlopeInBand{0, 100}, open)));
}

}  // namespace
}  // namespace aberfit
