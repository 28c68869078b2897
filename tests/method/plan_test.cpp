#include "aberfit/method/plan.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "aberfit/method/constants.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/study/read_study.h"
#include "aberfit/terms/surface_spectrum.h"

namespace aberfit {
namespace {

Study study_of(const std::string& psd) {
  return parse_study(
      R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "aperture": {"shape": "circle", "diameter": "0.4 m"},
          "light": {"wavelength": "632.8 nm"}, "roughness": {"psd": )" +
          psd + R"(}, "terms": {"zernike": {}}})",
      "study.json");
}

TEST(DefaultOrder, CarriesTheWholeBand) {
  for (const double f_max : {8.0, 14.0, 19.96, 25.0}) {
    const Study study = study_of(
        fmt::format(R"({{"model": "uniform", "rms": "100 nm", "f_min": "2.5 /m", "f_max": {}}})", f_max));
    const Groundwork ground = lay_groundwork(study);
    const TermPlan plan = plan_terms(study, ground, study.terms);
    EXPECT_EQ(plan.terms.zernike.back().n, int(std::ceil(1.1 * 2 * std::numbers::pi * 0.2 * f_max))) << f_max;
    EXPECT_GT(plan.captured, 0.99) << f_max;
  }
}

// exp(-(pi l f)^2) leaves 1e-3 of the slope variance above pi l f = 3.04: (1 + u) exp(-u) = 1e-3 at u = 9.23.
TEST(DefaultOrder, EndsWhereTheSlopesOfAGaussianDo) {
  const double l = 0.08;
  EXPECT_EQ(order_to_carry(0.2, band_end(RadialPsd(GaussianPsd{1e-7, l}))),
            int(std::ceil(1.1 * 2 * 0.2 * std::sqrt(9.2334) / l)));
  const Study study = study_of(R"({"model": "gaussian", "rms": "100 nm", "correlation_length": "8 mm"})");
  const Groundwork ground = lay_groundwork(study);
  EXPECT_GT(order_to_carry(0.2, band_end(*ground.psd)), law::kLargestOrder);
  double captured = 0;
  EXPECT_EQ(make_terms(study, ground, study.terms, &captured).zernike.back().n, law::kLargestOrder);
}

// Mean PSD of random coefficients in the last bin below the cut, over the disc. It is exact, because
// coefficients have the covariance L L^T and the PSD is quadratic in them.
double last_bin_of(const Study& study, const Groundwork& ground, int order) {
  TermsSpec asked;
  asked.zernike.emplace(ZernikeSpec{1, order});
  const TermPlan plan = plan_terms(study, ground, asked);
  const double cut = ground.term_psd->f_max();
  const auto spectrum =
      zernike_spectrum(plan.terms, Eigen::ArrayXd::Constant(1, cut * std::pow(2, -1 / law::kBinsPerOctave)),
                       Eigen::ArrayXd::Constant(1, cut));
  double sum = 0;
  Eigen::VectorXd value;
  for (Eigen::Index i = 0; i < plan.prior.size(); ++i) {
    spectrum->evaluate(plan.prior.colour(Eigen::VectorXd::Unit(plan.prior.size(), i)), &value, nullptr);
    sum += value[0];
  }
  return sum;
}

// The plateau of law::kOrderBeyondCut, against an order twice as high. From a twentieth beyond the cut on,
// terms carry all of the roughness; a quarter before it they lack a third and more.
TEST(DefaultOrder, HasAllOfTheLastBinBelowTheCut) {
  for (const char* psd : {R"({"model": "uniform", "rms": "100 nm", "f_min": "2.5 /m", "f_max": 12})",
                          R"({"model": "k-correlation", "rms": "100 nm", "correlation_length": "0.1 m",
                              "exponent": 2.5, "f_min": 1, "f_max": 12})"}) {
    const Study study = study_of(psd);
    const Groundwork ground = lay_groundwork(study);
    const double reach = 2 * std::numbers::pi * 0.2 * ground.term_psd->f_max(),
                 all = last_bin_of(study, ground, int(std::ceil(2 * reach)));
    const auto share = [&](double beyond) {
      return last_bin_of(study, ground, int(std::ceil(beyond * reach))) / all;
    };
    EXPECT_LT(last_bin_of(study, ground, int(0.75 * reach)), 0.7 * all) << psd;
    for (const double beyond : {1.05, law::kOrderBeyondCut, 1.25}) EXPECT_NEAR(share(beyond), 1, 4e-3) << psd;
  }
}

}  // namespace
}  // namespace aberfit
