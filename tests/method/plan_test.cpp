// What a study gets that leaves the choice to the program.
#include "aberfit/method/plan.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "aberfit/method/constants.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/study/read_study.h"

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

}  // namespace
}  // namespace aberfit
