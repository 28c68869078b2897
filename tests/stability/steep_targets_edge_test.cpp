// Targets of a theory of first order in the slope contradict each other for an exactly traced surface. Its
// radii exceed those that match its height and scatter angles by 4.6 slope^2, relative (PHYSICS 5).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/commands/run.h"
#include "aberfit/study/read_study.h"
#include "short_form.h"

namespace aberfit::test {
namespace {

// The surface has 304 plane waves of a uniform band 2 to 328 cycles across. Its RMS slope per axis is 9450 /m
// times its height.
ResultDocument fitted(double slope, const std::string& theory, const std::string& rays = "") {
  const double low = 15.53, high = 3006.86;
  const double per_height = 2 * std::numbers::pi * std::sqrt((low * low + high * high) / 4);
  return run_fit(parse_study(fmt::format(R"({{"aberfit": 1, "mirror": {{"focal_length": "3.6 m"}}, "aperture":
    {{"shape": "circle", "diameter": "0.109 m"}}, "light": {{"wavelength": "100 nm"}}, "roughness": {{"psd":
    {{"model": "uniform", "rms": {}, "f_min": {}, "f_max": {}}}}}, "terms": {{"fourier": {{"count": 304}}}},
    "target": {{"theory": "{}"}}, {} "fit": {{"starts": 1, "max_iterations": 30}},
    "output": {{"pictures": "none"}}}})",
                                         slope / per_height, low, high, theory, rays),
                             "study.json"),
                 {});
}

TEST_WITH_SHORT_FORM(StabilityEdge, SteepTargets) {
  // The slopes lie just before the edge, where the contradiction equals a tolerance, and beyond it.
  for (const double slope : aberfit::test::all_or_few(whole, std::vector{0.0146, 0.02, 0.045}, {1})) {
    const ResultDocument result = fitted(slope, "auto");
    EXPECT_EQ(result.scene.theory, slope > 0.015 ? "rays" : "ghs") << slope;
    EXPECT_EQ(result.fitted.fit.status, FitStatus::kConverged) << slope << ": " << result.fitted.fit.message;
    EXPECT_EQ(result.judgement.verdict, Verdict::kEquivalent) << slope;
  }
  // With the theory forced to be geometric, which `auto` avoids, the fit is far from its targets. It leaves
  // about seven of the nine tolerances by which theory and rays differ, 4.6 slope^2.
  const ResultDocument closed = fitted(0.045, "geometric", R"("trace": {"rays": 16384},)");
  EXPECT_NE(closed.fitted.fit.status, FitStatus::kConverged);
  double worst = 0;
  for (std::size_t k = 0; k < closed.fitted.targets.size(); ++k)
    worst =
        std::max(worst, std::abs(closed.fitted.values[Eigen::Index(k)] / closed.fitted.targets[k].value - 1));
  EXPECT_GT(worst, 0.55 * 4.6 * 0.045 * 0.045);
  EXPECT_LT(worst, 0.9 * 4.6 * 0.045 * 0.045);
}

}  // namespace
}  // namespace aberfit::test
