#include "aberfit/roughness/psd_in_band.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "aberfit/roughness/psd_integrals.h"

using namespace aberfit;

namespace {

const double kInf = std::numeric_limits<double>::infinity();

// Compares with the band of the evaluated PSD: values inside and outside, and the variance.
void expect_band(const PsdModel& model, double f_min, double f_max, double tolerance) {
  const std::optional<PsdModel> inside = psd_in_band(model, f_min, f_max);
  ASSERT_TRUE(inside);
  ASSERT_EQ(psd_problem(*inside), "");
  const RadialPsd expected = RadialPsd(model).band(f_min, f_max), got(*inside);
  for (double f = 0.13; f < 1e5; f *= 1.17) {
    const double s = expected(f);
    if (s > 1e-24 * expected(std::max(expected.f_min(), 0.1))) {
      EXPECT_NEAR(got(f) / s, 1, tolerance) << f;
    } else if (s == 0) {
      EXPECT_EQ(got(f), 0) << f;
    }
  }
  EXPECT_NEAR(radial_moment(got, 0) / radial_moment(expected, 0), 1, tolerance);
}

}  // namespace

TEST(PsdInBand, IsTheBandOfEveryFamily) {
  expect_band(UniformPsd{1e-8, 10, 1000}, 50, 400, 1e-12);
  expect_band(KCorrelationPsd{1e-8, 0.3, 2.8, 0.8, 200}, 6, kInf, 1e-12);
  expect_band(KCorrelationPsd{1e-8, 0.3, 2.8, 0, kInf}, 6, kInf, 1e-12);
  expect_band(PowerLawPsd{1e-8, {}, 2.2, 1, 1e4}, 10, 1e3, 1e-12);
  expect_band(PowerLawPsd{{}, 1e-18, 3.0, 1, 1e4}, 10, 1e5, 1e-12);
  expect_band(TablePsd{{1, 10, 100, 1000}, {1e-18, 1e-19, 3e-22, 1e-24}}, 4, 300, 1e-12);
  expect_band(GaussianPsd{1e-8, 1e-3}, 0, kInf, 1e-12);
  expect_band(GaussianPsd{1e-8, 1e-3}, 30, kInf, 1e-3);
  expect_band(GaussianPsd{1e-8, 1e-3}, 0, 700, 1e-3);
  expect_band(SumPsd{{KCorrelationPsd{1e-8, 0.3, 2.8, 0.8, 200}, UniformPsd{3e-9, 50, 1000},
                      UniformPsd{3e-9, 0.8, 2}}},
              6, kInf, 1e-12);
}

TEST(PsdInBand, KeepsTheParameters) {
  const std::optional<PsdModel> rest = psd_in_band(KCorrelationPsd{1e-8, 0.3, 2.8, 0.8, 200}, 6, kInf);
  const auto& k = std::get<KCorrelationPsd>(rest.value());
  EXPECT_EQ(k.correlation, 0.3);
  EXPECT_EQ(k.exponent, 2.8);
  EXPECT_EQ(k.f_min, 6);
  EXPECT_EQ(k.f_max, 200);
  EXPECT_LT(k.rms, 1e-8);
  // A sum with one part left is that part.
  EXPECT_TRUE(std::holds_alternative<UniformPsd>(
      psd_in_band(SumPsd{{UniformPsd{1e-8, 1, 2}, UniformPsd{1e-9, 3, 4}}}, 2.5, kInf).value()));
}

TEST(PsdInBand, OfNothingIsEmpty) {
  for (const PsdModel& model :
       {PsdModel(UniformPsd{1e-8, 1, 2}), PsdModel(KCorrelationPsd{1e-8, 0.3, 2.8, 0.1, 2}),
        PsdModel(PowerLawPsd{1e-8, {}, 2.0, 1, 2}), PsdModel(TablePsd{{1, 2}, {1e-18, 1e-18}}),
        PsdModel(GaussianPsd{1e-8, 10.0}),
        PsdModel(SumPsd{{UniformPsd{1e-8, 1, 2}, UniformPsd{1e-8, 2, 3}}})})
    EXPECT_FALSE(psd_in_band(model, 5, 9)) << model.index();
}
