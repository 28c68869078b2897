// Pupils and light of telescopes: segments, spiders, a filter. A wave code of the tests' own checks each
// verdict.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <string>

#include "aberfit/commands/run.h"
#include "aberfit/study/read_study.h"
#include "independent_verdict.h"

namespace aberfit {
namespace {

// The roughness reaches 200 cycles across.
const char* const kHexagons = R"({"aberfit": 1, "mirror": {"focal_length": "17.5 m"},
  "aperture": {"shape": "segments", "hexagons": {"rings": 3, "flat_to_flat": "1.35 m", "gap": "4 mm"}},
  "light": {"wavelength": "2 um"},
  "roughness": {"psd": {"model": "k-correlation", "rms": "60 nm", "B": "3 m", "exponent": 3,
                        "f_min": "0.1 /m", "f_max": "20 /m"}}})";
const char* const kSpider = R"({"aberfit": 1, "mirror": {"focal_length": "2.4 m"},
  "aperture": {"shape": "annulus", "diameter": "1 m", "inner_diameter": "0.3 m", "spiders": [
    {"width": "15 mm", "angle": "45 deg"}, {"width": "15 mm", "angle": "135 deg"},
    {"width": "15 mm", "angle": "225 deg"}, {"width": "15 mm", "angle": "315 deg"}]},
  "light": {"band": {"from": "500 nm", "to": "600 nm", "count": 5}},
  "roughness": {"psd": {"model": "k-correlation", "rms": "20 nm", "B": "0.3 m", "exponent": 3,
                        "f_min": "1 /m", "f_max": "100 /m"}}})";

void expect_true_in_light(const char* text) {
  const Study study = parse_study(text, "telescope.json");
  const auto begin = std::chrono::steady_clock::now();
  const ResultDocument result = run_fit(study, {});
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  ASSERT_EQ(result.judgement.verdict, Verdict::kEquivalent);
  ASSERT_TRUE(result.band.shares);
  const SecondOpinion light =
      SecondOpinions(study).of_waves(result.fitted.terms, result.fitted.fit.coefficients,
                                     result.band.shares->cut, {.seconds = 7200, .narrow_field = true});
  std::printf("%d terms, %.1f s, worst by waves %.2f (%s)\n", int(result.fitted.terms.size()),
              seconds.count(), light.worst, light.statistic.c_str());
  EXPECT_LE(light.worst, 1.0) << light.statistic << light.obstacle;
}

// The same with segments offset by 30 nm in piston, and by as much at their corners.
std::string erring_hexagons(const std::string& errors) {
  std::string text = kHexagons;
  const std::string place = R"("gap": "4 mm"})";
  return text.insert(text.find(place) + place.size(), ", " + errors);
}

TEST(Telescopes, OfSegmentsIsTrueInLight) { expect_true_in_light(kHexagons); }
TEST(Telescopes, OfSegmentsThatStandApartIsTrueInLight) {
  expect_true_in_light(erring_hexagons(R"("piston": "30 nm")").c_str());
}
TEST(Telescopes, OfSegmentsThatTiltIsTrueInLight) {
  expect_true_in_light(erring_hexagons(R"("piston": "30 nm", "tip_tilt": "40 nrad")").c_str());
}
TEST(Telescopes, WithASpiderInAFilterIsTrueInLight) { expect_true_in_light(kSpider); }

}  // namespace
}  // namespace aberfit
