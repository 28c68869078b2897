// What a study gets that leaves the choice to the program.
#include "aberfit/method/plan.h"

#include <gtest/gtest.h>

#include "aberfit/method/groundwork.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

// Of the height variance that terms from n = 2 on can carry.
TEST(DefaultOrder, IsTheLowestThatCarries99Percent) {
  for (const char* f_max : {"8 /m", "14 /m", "25 /m"}) {
    const Study study = parse_study(
        std::string(
            R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "aperture": {"shape": "circle", "diameter": "0.4 m"},
              "light": {"wavelength": "632.8 nm"},
              "roughness": {"psd": {"model": "uniform", "rms": "100 nm", "f_min": "2.5 /m", "f_max": ")") +
            f_max + R"("}}, "terms": {"zernike": {}}})",
        "study.json");
    const Groundwork ground = lay_groundwork(study);
    const TermPlan plan = plan_terms(study, ground, study.terms);
    const int n = plan.terms.zernike.back().n;
    const auto share = [&](int n_max) {
      return captured_fraction(*ground.psd, 0.2, 2, n_max) / (1 - captured_fraction(*ground.psd, 0.2, 0, 1));
    };
    EXPECT_GE(share(n), 0.99) << f_max;
    EXPECT_LT(share(n - 1), 0.99) << f_max;
    EXPECT_NEAR(plan.captured, share(n), 1e-9);
  }
}

}  // namespace
}  // namespace aberfit
