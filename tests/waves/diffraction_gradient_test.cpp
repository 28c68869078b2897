#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "aberfit/core/quadrature.h"
#include "aberfit/core/random.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFocal = 2.8, kDiameter = 0.4, kWave = 632.8e-9;

// A number with its derivatives with respect to all variables.
struct Dual {
  double v = 0;
  Eigen::ArrayXd d;
};
Dual operator+(const Dual& a, const Dual& b) { return {a.v + b.v, a.d + b.d}; }
Dual operator-(const Dual& a, const Dual& b) { return {a.v - b.v, a.d - b.d}; }
Dual operator*(const Dual& a, const Dual& b) { return {a.v * b.v, a.v * b.d + b.v * a.d}; }
Dual operator*(double a, const Dual& b) { return {a * b.v, a * b.d}; }
Dual operator/(const Dual& a, const Dual& b) { return {a.v / b.v, (a.d - a.v / b.v * b.d) / b.v}; }
Dual sin(const Dual& a) { return {std::sin(a.v), std::cos(a.v) * a.d}; }
Dual cos(const Dual& a) { return {std::cos(a.v), -std::sin(a.v) * a.d}; }

// The PSF by direct summation in doubles or duals, without Fourier transforms or a transfer function.
template <typename T>
class Direct {
 public:
  Direct(const DiffractionPupil& pupil, std::vector<T> height, T zero)
      : pupil_(pupil), height_(std::move(height)), zero_(zero) {}

  // |U(X, Y)|^2 (pitch/(lambda (f+dz)))^2 / total [1/m^2]
  T intensity(const T& x, const T& y, const T& dz) const {
    using std::cos, std::sin;
    T re = zero_, im = zero_;
    const T distance = dz + constant(kFocal);
    const T chirp = constant(kPi / (kWave * kFocal)) * dz / distance;
    for (Eigen::Index k = 0; k < pupil_.cover.size(); ++k) {
      const double px = pupil_.sample.x[k], py = pupil_.sample.y[k];
      const T phase = (4 * kPi / kWave) * height_[std::size_t(k)] + (px * px + py * py) * chirp +
                      (2 * kPi / kWave) * ((px * x + py * y) / distance);
      re = re + pupil_.amplitude[k] * cos(phase);
      im = im - pupil_.amplitude[k] * sin(phase);
    }
    const double total = pupil_.cover.sum(), pitch = pupil_.pitch_x / kWave;
    return (pitch * pitch / total) * ((re * re + im * im) / (distance * distance));
  }
  // Encircled energy of radius r, by Gauss-Legendre over the radius and equal angles; spectrally accurate.
  T energy(const T& r, const T& dz) const {
    constexpr int kRadii = 20, kAngles = 48;
    const Quadrature rule = gauss_legendre(kRadii, 0.0, 1.0);
    T sum = zero_;
    for (int i = 0; i < kRadii; ++i)
      for (int j = 0; j < kAngles; ++j) {
        const double angle = 2 * kPi * (j + 0.25) / kAngles, t = rule.nodes[i];
        sum = sum + (rule.weights[i] * t * 2 * kPi / kAngles) *
                        intensity((t * std::cos(angle)) * r, (t * std::sin(angle)) * r, dz);
      }
    return r * r * sum;
  }
  // Integral over one period of the other axis. Equal steps are exact for a band-limited function.
  T line(const T& position, bool along_x) const {
    constexpr int kSteps = 24;
    const double period = kWave * kFocal / pupil_.pitch_x;
    T sum = zero_;
    for (int j = 0; j < kSteps; ++j) {
      const T other = constant(period * j / kSteps);
      sum = sum + (period / kSteps) *
                      (along_x ? intensity(position, other, zero_) : intensity(other, position, zero_));
    }
    return sum;
  }
  T constant(double v) const {
    T result = zero_;
    return set(result, v);
  }

 private:
  static double set(double, double v) { return v; }
  static Dual set(Dual zero, double v) { return {v, zero.d}; }

  const DiffractionPupil& pupil_;
  std::vector<T> height_;
  T zero_;
};

double bisect(const std::function<double(double)>& f, double a, double b) {
  const bool up = f(b) > 0;
  for (int k = 0; k < 60; ++k) {
    const double c = 0.5 * (a + b);
    ((f(c) > 0) == up ? b : a) = c;
  }
  return 0.5 * (a + b);
}

class DiffractionGradient : public testing::Test {
 protected:
  // 9 cells across with heights of 40 nm: every term matters, and direct sums stay cheap.
  DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / 9);
  // Some phase steps of independent heights exceed pi, which does not affect sums.
  DiffractionProblem problem{pupil, kFocal, kWave, 1};
  Eigen::Index n = pupil.cover.size();
  Eigen::ArrayXd height = draw();
  Dual zero{0, Eigen::ArrayXd::Zero(n + 1)};  // derivatives over the heights and one more variable
  Direct<double> plain{pupil, std::vector<double>(height.begin(), height.end()), 0.0};
  Direct<Dual> dual{pupil, variables(), zero};

  Eigen::ArrayXd draw() const {
    const RandomStream stream(7, "diffraction-gradient");
    Eigen::ArrayXd result(n);
    for (Eigen::Index k = 0; k < n; ++k) result[k] = 40e-9 * stream.normal(std::uint64_t(k));
    return result;
  }
  std::vector<Dual> variables() const {
    std::vector<Dual> result;
    for (Eigen::Index k = 0; k < n; ++k) {
      result.push_back({height[k], Eigen::ArrayXd::Zero(n + 1)});
      result.back().d[k] = 1;
    }
    return result;
  }
  Dual extra(double v) const {  // the additional variable
    Dual result = dual.constant(v);
    result.d[n] = 1;
    return result;
  }
  // x(h) with f(x, h) = 0 has the derivative -f_h/f_x. f: value and derivatives; x is the extra variable.
  Dual implicit(double x, const Dual& f) const {
    Dual result{x, -f.d / f.d[n]};
    result.d[n] = 0;
    return result;
  }
  Dual radius(double fraction, double dz) const {
    const double r = bisect([&](double t) { return plain.energy(t, dz) - fraction; }, 1e-7, 1.7e-5);
    return implicit(r, dual.energy(extra(r), dual.constant(dz)) - dual.constant(fraction));
  }
  void expect_equal(const Statistic& statistic, const Dual& expected) {
    Eigen::VectorXd values;
    std::vector<Eigen::ArrayXd> gradient;
    ASSERT_TRUE(evaluate_diffraction(problem, height, {statistic}, 1, nullptr, &values, &gradient));
    EXPECT_NEAR(values[0] / expected.v, 1, 1e-9) << statistic_name(statistic);
    const Eigen::ArrayXd d = expected.d.head(n);
    EXPECT_LT((gradient[0] - d).abs().maxCoeff(), 1e-8 * d.abs().maxCoeff()) << statistic_name(statistic);
  }
};

TEST_F(DiffractionGradient, OfEncircledEnergyRadiiAgreesWithDualNumbersThroughDirectSums) {
  expect_equal(EncircledEnergyRadius{0.5, 0}, radius(0.5, 0));
  expect_equal(EncircledEnergyRadius{0.35, 1.5e-4}, radius(0.35, 1.5e-4));
}

TEST_F(DiffractionGradient, OfTheShareInARingAgreesWithDualNumbersThroughDirectSums) {
  expect_equal(RingThrough{9e-6, -2e-4}, dual.energy(dual.constant(9e-6), dual.constant(-2e-4)));
}

TEST_F(DiffractionGradient, OfTheRingWidthAgreesWithDualNumbersThroughDirectSums) {
  const Dual ring = radius(0.4, 0);
  const auto share = [&](double z) { return plain.energy(ring.v, z); };
  double top = 0;
  for (int k = -40; k <= 40; ++k)
    if (share(k * 2e-5) > share(top)) top = k * 2e-5;
  const auto slope = [&](double z) { return dual.energy(dual.constant(ring.v), extra(z)).d[n]; };
  // Bisection of an exact slope, from 4e-5 to 1e-15 m.
  double low = top - 2e-5, high = top + 2e-5;
  for (int k = 0; k < 36; ++k) (slope(0.5 * (low + high)) > 0 ? low : high) = 0.5 * (low + high);
  const double peak = 0.5 * (low + high), half = 0.5 * share(peak);
  Dual best = dual.energy(ring, dual.constant(peak));
  const auto crossing = [&](double step) {
    double outside = peak;
    while (share(outside) >= half) outside += step;
    const double z = bisect([&](double t) { return share(t) - half; }, outside - step, outside);
    return implicit(z, dual.energy(ring, extra(z)) - 0.5 * best);
  };
  expect_equal(RingFwhm{0.4, std::nullopt}, crossing(2e-5) - crossing(-2e-5));
}

TEST_F(DiffractionGradient, OfTheLineSpreadWidthAgreesWithDualNumbersThroughDirectSums) {
  Dual width = dual.constant(0);
  for (const bool along_x : {true, false}) {
    const auto profile = [&](double x) { return plain.line(x, along_x); };
    double top = 0;
    for (int k = -150; k <= 150; ++k)
      if (profile(k * 1e-7) > profile(top)) top = k * 1e-7;
    const auto slope = [&](double x) { return dual.line(extra(x), along_x).d[n]; };
    const double peak = bisect(slope, top - 1e-7, top + 1e-7), half = 0.5 * profile(peak);
    const Dual best = dual.line(dual.constant(peak), along_x);
    const auto crossing = [&](double step) {
      double outside = peak + std::copysign(1.9e-5, step);
      while (profile(outside - step) < half) outside -= step;
      const double x = bisect([&](double t) { return profile(t) - half; }, outside - step, outside);
      return implicit(x, dual.line(extra(x), along_x) - 0.5 * best);
    };
    width = width + 0.5 * (crossing(1e-7) - crossing(-1e-7));
  }
  expect_equal(SpotFwhm{0}, width);
}

// Central differences extrapolated to step 0 (Ridders 1982).
double ridders(const std::function<double(double)>& f, double step) {
  constexpr int kRows = 6;
  double table[kRows][kRows], best = 0, error = HUGE_VAL;
  for (int i = 0; i < kRows; ++i, step /= 1.6) {
    table[i][0] = (f(step) - f(-step)) / (2 * step);
    double factor = 1.6 * 1.6;
    for (int j = 1; j <= i; ++j, factor *= 1.6 * 1.6) {
      table[i][j] = (table[i][j - 1] * factor - table[i - 1][j - 1]) / (factor - 1);
      const double e =
          std::max(std::abs(table[i][j] - table[i][j - 1]), std::abs(table[i][j] - table[i - 1][j - 1]));
      if (e < error) error = e, best = table[i][j];
    }
  }
  return best;
}

TEST(DiffractionCoefficientGradient, AgreesWithDifferencesOverZernikeAndFourierTerms) {
  const DiffractionPupil pupil =
      diffraction_pupil(AnnulusAperture{kDiameter, 0.1}, kParaxial, kDiameter / 48);
  const DiffractionProblem problem{pupil, kFocal, kWave};
  TermSet terms;
  terms.radius = 0.5 * kDiameter;
  terms.zernike = zernike_modes(2, 5);
  terms.fourier = {{12.5, 3}, {-7, 21}};
  const SurfaceOperator surface(terms, pupil.sample, OperatorOptions{});
  const RandomStream stream(11, "diffraction-coefficients");
  Eigen::VectorXd c(terms.size()), direction(terms.size());
  for (Eigen::Index k = 0; k < c.size(); ++k) {
    c[k] = 12e-9 * stream.normal(std::uint64_t(k));
    direction[k] = 1e-9 * stream.normal(1000 + std::uint64_t(k));
  }
  const std::vector<Statistic> statistics = {EncircledEnergyRadius{0.5, 0},
                                             EncircledEnergyRadius{0.9, 0},
                                             EncircledEnergyRadius{0.8, 3e-4},
                                             RingThrough{8e-6, -2e-4},
                                             RingFwhm{0.8, std::nullopt},
                                             RingFwhm{0, 1.1e-5},
                                             SpotFwhm{0},
                                             SpotFwhm{1.5e-6}};
  DiffractionWorkspace workspace;
  SurfaceField field;
  const auto values_at = [&](double t) {
    surface.apply(c + t * direction, &field);
    Eigen::VectorXd values;
    EXPECT_TRUE(evaluate_diffraction(problem, field.height, statistics, 1, &workspace, &values, nullptr));
    return values;
  };
  surface.apply(c, &field);
  Eigen::VectorXd values;
  std::vector<Eigen::ArrayXd> d_height;
  ASSERT_TRUE(evaluate_diffraction(problem, field.height, statistics, 1, &workspace, &values, &d_height))
      << values.transpose();
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    SurfaceField weights;
    weights.resize(field.size());
    weights.height = d_height[k];
    weights.slope_x.setZero();
    weights.slope_y.setZero();
    const double exact = surface.apply_transpose(weights).dot(direction);
    const double differenced = ridders([&](double t) { return values_at(t)[Eigen::Index(k)]; }, 0.2);
    EXPECT_NEAR(exact / differenced, 1, 1e-8) << statistic_name(statistics[k]);
  }
}

TEST(DiffractionCoefficientGradient, VanishesAtThePerfectMirror) {
  // Every energy is stationary at flat phase, because changes are in quadrature. A fit must not start there.
  const DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kParaxial, kDiameter / 32);
  const DiffractionProblem problem{pupil, kFocal, kWave};
  Eigen::VectorXd values;
  std::vector<Eigen::ArrayXd> d_height;
  const Eigen::ArrayXd flat = Eigen::ArrayXd::Zero(pupil.cover.size());
  ASSERT_TRUE(
      evaluate_diffraction(problem, flat, {EncircledEnergyRadius{0.5, 0}}, 1, nullptr, &values, &d_height));
  EXPECT_LT(d_height[0].abs().sum() * 1e-9, 1e-12 * values[0]);
}

}  // namespace
}  // namespace aberfit
