#include "aberfit/roughness/psd.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/roughness/k_correlation.h"
#include "aberfit/roughness/psd_integrals.h"

using namespace aberfit;
using std::numbers::pi;

namespace {
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kMoment = 1e-12;  // relative error from the header
double relative(double value, double truth) { return std::abs(value / truth - 1); }
}  // namespace

TEST(PsdModel, NormalisesTheRmsInsideItsBand) {
  const std::vector<PsdModel> models = {
      UniformPsd{1e-7, 2.5, 39.92},
      UniformPsd{1e-7, 0, 1e6},
      UniformPsd{1e-7, 10, 10.001},
      KCorrelationPsd{1e-7, 0.02, 3.0, 0, kInf},
      KCorrelationPsd{1e-7, 0.02, 2.0, 0, 1e6},
      KCorrelationPsd{1e-7, 0.02, 2.0000001, 1, 1e6},
      KCorrelationPsd{1e-7, 5.0, 2.2, 1e-3, 1e4},
      KCorrelationPsd{1e-7, 1e-6, 80, 0, kInf},
      PowerLawPsd{1e-7, {}, 2.0, 1, 1e5},
      PowerLawPsd{1e-7, {}, 11.0 / 3, 0.5, kInf},
      PowerLawPsd{1e-7, {}, 1.9, 0, 100},
      PowerLawPsd{1e-7, {}, -1.5, 0, 100},
      GaussianPsd{1e-7, 0.01},
  };
  for (std::size_t i = 0; i < models.size(); ++i) {
    ASSERT_EQ(psd_problem(models[i]), "") << i;
    EXPECT_LT(relative(psd_moments(RadialPsd(models[i])).rms_height(), 1e-7), kMoment) << "model " << i;
  }
}

TEST(PsdMoments, OfAUniformBandAreTheClosedForms) {
  const double s = 1e-7, a = 2.5, b = 19.96;
  const PsdMoments m = psd_moments(RadialPsd(UniformPsd{s, a, b}));
  const double level = s * s / (pi * (b * b - a * a));
  EXPECT_LT(relative(m.height_variance, s * s), kMoment);
  EXPECT_LT(relative(m.slope_variance, 2 * pi * pi * s * s * (b * b + a * a)), kMoment);
  EXPECT_LT(relative(m.f2_squared, level * level * pi / 3 * (std::pow(b, 6) - std::pow(a, 6))), kMoment);
  EXPECT_NEAR(m.rms_slope_per_axis(), 6.32e-6, 0.005e-6);  // the reference value has three digits
}

TEST(PsdMoments, OfAGaussianAreTheClosedForms) {
  const double s = 2e-8, l = 3e-3;
  const PsdMoments m = psd_moments(RadialPsd(GaussianPsd{s, l}));
  EXPECT_LT(relative(m.slope_variance, 4 * s * s / (l * l)), kMoment);
  // 2 pi int f^5 S^2 df with S^2 = (pi l^2 s^2)^2 exp(-2 (pi l f)^2): 2 pi (pi l^2 s^2)^2 / (2 pi^2 l^2)^3.
  EXPECT_LT(
      relative(m.f2_squared, 2 * pi * std::pow(pi * l * l * s * s, 2) / std::pow(2 * pi * pi * l * l, 3)),
      kMoment);
  // Only the distant tail: int_a^inf gives exp(-(pi l a)^2) = e^-355 of the variance.
  const double a = 6 / l;
  const double tail = radial_moment(RadialPsd(GaussianPsd{s, l}), 0, a, kInf);
  EXPECT_LT(relative(tail, s * s * std::exp(-std::pow(pi * l * a, 2))),
            1e-12);  // exp amplifies rounding by 355
}

TEST(PsdMoments, OfAKCorrelationAreTheClosedForms) {
  // With v = 1 + (B f)^2 the slope integral for c = 6 is 4 pi^2 pi A/B^4 int (v-1) v^-3 dv = 4 pi^3 A/(2
  // B^4), and the variance is pi A/(2 B^2).
  const double s = 1e-7, B = 0.04;
  const PsdMoments m = psd_moments(RadialPsd(KCorrelationPsd{s, B, 6.0, 0, kInf}));
  const double A = 2 * B * B * s * s / pi;
  EXPECT_LT(relative(m.slope_variance, 2 * pi * pi * pi * A / std::pow(B, 4)), kMoment);
  // int f^4 S^2 d2f = pi A^2/B^6 int u^2 (1+u)^-6 du = pi A^2/B^6 Beta(3, 3) = pi A^2 / (30 B^6).
  EXPECT_LT(relative(m.f2_squared, pi * A * A / (30 * std::pow(B, 6))), kMoment);
}

TEST(PsdMoments, AreInfiniteWhereTheIntegralDiverges) {
  const PsdMoments k = psd_moments(RadialPsd(KCorrelationPsd{1e-7, 0.02, 3.5, 0, kInf}));
  EXPECT_TRUE(std::isinf(k.slope_variance));
  EXPECT_TRUE(std::isfinite(k.f2_squared));
  EXPECT_TRUE(std::isinf(effective_modes(k, 1.0)));
  const PsdMoments kolmogorov = psd_moments(RadialPsd(PowerLawPsd{{}, 0.0229, 11.0 / 3, 0, kInf}));
  EXPECT_TRUE(std::isinf(kolmogorov.height_variance));
  EXPECT_TRUE(std::isinf(kolmogorov.slope_variance));
  EXPECT_TRUE(std::isinf(psd_moments(RadialPsd(KCorrelationPsd{1e-7, 0.02, 2.9, 0, kInf})).f2_squared));
}

TEST(PsdMoments, OfASumAddAndCrossTermsCountInTheSquare) {
  const double low = 1e-7, high = 2e-8;
  const RadialPsd sum(SumPsd{{UniformPsd{low, 1, 10}, UniformPsd{high, 5, 50}}});
  const PsdMoments m = psd_moments(sum);
  EXPECT_LT(relative(m.height_variance, low * low + high * high), kMoment);
  const double s1 = low * low / (pi * 99), s2 = high * high / (pi * 2475);
  const auto sixth = [](double a, double b) { return pi / 3 * (std::pow(b, 6) - std::pow(a, 6)); };
  const double square =
      s1 * s1 * sixth(1, 5) + (s1 + s2) * (s1 + s2) * sixth(5, 10) + s2 * s2 * sixth(10, 50);
  EXPECT_LT(relative(m.f2_squared, square), kMoment);
  EXPECT_EQ(sum.breakpoints(), (std::vector<double>{1, 5, 10, 50}));
}

TEST(RadialPsd, BandAndScaleActOnTheMomentsAsTheyShould) {
  const RadialPsd whole(KCorrelationPsd{1e-7, 0.02, 3.0, 0, kInf});
  const double below = psd_moments(whole.band(0, 70)).height_variance;
  const double above = psd_moments(whole.band(70, kInf)).height_variance;
  EXPECT_LT(relative(below + above, 1e-14), kMoment);
  EXPECT_LT(relative(psd_moments(whole.scaled(3)).height_variance, 9e-14), kMoment);
  const RadialPsd nothing = RadialPsd(UniformPsd{1e-7, 1, 2}).band(3, 4);
  EXPECT_EQ(psd_moments(nothing).height_variance, 0);
  EXPECT_EQ(nothing(3.5), 0);
  EXPECT_EQ(whole.band(10, 20)(9.99), 0);
  EXPECT_EQ(whole.band(10, 20)(15), whole(15));
}

TEST(EffectiveModes, OfAFilledUniformBandAreThreeQuartersOfTheModesInTheBand) {
  // S is constant on [0, b]: (pi S b^4/2)^2 / (pi S^2 b^6/3) = 3/4 pi b^2.
  const double b = 40, area = pi * 0.04;
  const double modes = effective_modes(psd_moments(RadialPsd(UniformPsd{1e-7, 0, b})), area);
  EXPECT_LT(relative(modes, 0.75 * pi * b * b * area), 1e-11);
}

TEST(PsdTable, InterpolatesPowersExactlyAndVanishesOutside) {
  TablePsd table;
  for (const double f : {1.0, 3.0, 4.0, 20.0}) {
    table.frequency.push_back(f);
    table.psd.push_back(1e-16 * std::pow(f, -2.5));
  }
  const RadialPsd psd(table);
  EXPECT_LT(relative(psd(2.0), 1e-16 * std::pow(2.0, -2.5)), 1e-14);
  EXPECT_LT(relative(psd(20.0), 1e-16 * std::pow(20.0, -2.5)), 1e-14);
  EXPECT_EQ(psd(0.99), 0);
  EXPECT_EQ(psd(20.01), 0);
  EXPECT_LT(relative(psd_moments(psd).height_variance, 2 * pi * 1e-16 * (1 - std::pow(20.0, -0.5)) / 0.5),
            kMoment);
}

TEST(KCorrelation, ProfilePsdIsTheIntegralOfTheSurfacePsdOverTheOtherFrequency) {
  const KCorrelation1d profile{3e-18, 0.05, 1.7};
  const KCorrelation2d surface = k_correlation_1d_to_2d(profile);
  EXPECT_DOUBLE_EQ(surface.exponent, 2.7);
  for (const double fx : {0.0, 3.0, 20.0, 400.0}) {
    // f_y = w tan(t) turns int dfy (w^2 + fy^2)^(-c/2) into w^(1-c) int cos(t)^(c-2) dt, w^2 = fx^2 + 1/B^2.
    // The tanh-sinh rule is a trapezoid in s with t = (pi/2) tanh(sinh(s)), where both ends decay
    // double-exponentially.
    const double w = std::hypot(fx, 1 / surface.correlation), c = surface.exponent, h = 1.0 / 64;
    double sum = 0;
    for (int i = -400; i <= 400; ++i) {
      const double s = i * h, q = std::exp(-2 * std::abs(std::sinh(s))),
                   distance = pi * q / (1 + q);  // pi/2 - |t|
      sum += std::pow(std::sin(distance), c - 2) * 0.5 * pi * std::cosh(s) * 4 * q / ((1 + q) * (1 + q)) * h;
    }
    const double integral = surface.amplitude * std::pow(surface.correlation, -c) * std::pow(w, 1 - c) * sum;
    const double one_sided = profile.amplitude * std::pow(1 + std::pow(profile.correlation * fx, 2), -0.85);
    EXPECT_LT(relative(2 * integral, one_sided), 1e-11) << fx;
  }
  const KCorrelation1d back = k_correlation_2d_to_1d(surface);
  EXPECT_LT(relative(back.amplitude, profile.amplitude), 1e-14);
  EXPECT_DOUBLE_EQ(back.exponent, profile.exponent);
  EXPECT_THROW(k_correlation_2d_to_1d({1, 1, 1}), std::domain_error);
  EXPECT_THROW(k_correlation_1d_to_2d({1, 1, 0}), std::domain_error);
}

TEST(KCorrelation, ModelInABandKeepsTheAmplitude) {
  const KCorrelation2d surface{2e-17, 0.03, 2.6};
  const RadialPsd psd(k_correlation_model(surface, 5, 800));
  for (const double f : {5.0, 40.0, 799.0})
    EXPECT_LT(relative(psd(f), 2e-17 * std::pow(1 + std::pow(0.03 * f, 2), -1.3)), 1e-13);
  EXPECT_THROW(k_correlation_model({1, 1, 1.5}), std::domain_error);
}

TEST(PsdProblem, NamesWhatIsWrongAndNothingWhenAllIsWell) {
  const std::vector<std::pair<PsdModel, std::string>> bad = {
      {UniformPsd{-1e-7, 1, 2}, "rms"},
      {UniformPsd{0, 1, 2}, "rms"},
      {UniformPsd{NAN, 1, 2}, "rms"},
      {UniformPsd{1e-7, 3, 2}, "f_max"},
      {UniformPsd{1e-7, -1, 2}, "f_min"},
      {UniformPsd{1e-7, 1, kInf}, "finite f_max"},
      {UniformPsd{1e-7, 1, NAN}, "f_max"},
      {KCorrelationPsd{1e-7, 0, 3, 0, kInf}, "B is"},
      {KCorrelationPsd{1e-7, 1, 2, 0, kInf}, "greater than 2"},
      {KCorrelationPsd{1e-7, 1, -3, 0, 10}, "exponent"},
      {PowerLawPsd{{}, {}, 2, 1, 2}, "exactly one"},
      {PowerLawPsd{1e-7, 1e-7, 2, 1, 2}, "exactly one"},
      {PowerLawPsd{1e-7, {}, 11.0 / 3, 0, kInf}, "less than 2"},
      {PowerLawPsd{1e-7, {}, 1.5, 1, kInf}, "greater than 2"},
      {PowerLawPsd{{}, -1.0, 3, 1, 2}, "amplitude"},
      {PowerLawPsd{{}, 1.0, NAN, 1, 2}, "exponent"},
      {PowerLawPsd{{}, 1.0, 3, 0, 0}, "f_max"},
      {GaussianPsd{1e-7, 0}, "correlation length"},
      {TablePsd{{1, 2}, {1}}, "2 frequencies but 1"},
      {TablePsd{{1}, {1}}, "at least 2"},
      {TablePsd{{1, 3, 2}, {1, 1, 1}}, "point 3"},
      {TablePsd{{1, 3}, {1, 0}}, "point 2"},
      {TablePsd{{0, 3}, {1, 1}}, "point 1"},
      {SumPsd{}, "at least one part"},
      {SumPsd{{UniformPsd{1, 1, 2}, GaussianPsd{1e-7, -1}}}, "part 2"},
  };
  for (std::size_t i = 0; i < bad.size(); ++i) {
    const std::string text = psd_problem(bad[i].first);
    EXPECT_NE(text.find(bad[i].second), std::string::npos) << i << ": " << text;
  }
  EXPECT_EQ(psd_problem(PowerLawPsd{{}, 0.0229, 11.0 / 3, 0, kInf}), "");
  EXPECT_EQ(psd_problem(SumPsd{{GaussianPsd{1e-9, 1e-3}, SumPsd{{UniformPsd{1e-9, 0, 5}}}}}), "");
}

TEST(PsdModels, ScaledInHeightsAndFrequenciesHaveTheScaledPsd) {
  const TablePsd table{{2, 3, 40}, {3e-17, 5e-17, 4e-19}};
  const std::vector<PsdModel> models = {
      UniformPsd{1e-7, 2, 40},           KCorrelationPsd{1e-7, 0.1, 2.4, 1, 1e3},
      PowerLawPsd{1e-7, {}, 2.4, 1, 50}, PowerLawPsd{{}, 1e-16, 3.3, 1, 50},
      GaussianPsd{1e-7, 0.01},           table};
  const double heights = 1.7, frequencies = 0.6;
  for (const PsdModel& model : models) {
    const RadialPsd before(model), after(scaled(model, heights, frequencies));
    for (const double f : {2.5, 7.0, 39.0}) {
      const double truth = std::pow(heights / frequencies, 2) * before(f);
      EXPECT_NEAR(after(f * frequencies) / truth, 1, 1e-13) << model.index() << " " << f;
    }
  }
}
