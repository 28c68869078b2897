// Tests ceilings against closed laws of PHYSICS 5 and 6, and against the targets of a study at a ceiling.
#include "aberfit/specify/ceilings.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

using std::numbers::pi;

constexpr double kArcsec = pi / 648000;

// f/500, with a paraxial error of 1.3e-7; no roughness block.
Ceilings found(const std::string& target, const std::string& ceilings, const std::string& so_that) {
  const std::string text =
      R"({"aberfit": 1, "mirror": {"focal_length": "100 m"}, "light": {"wavelength": "500 nm"},
      "aperture": {"shape": "circle", "diameter": "0.2 m"}, "target": {)" +
      target + R"(}, "solve": {"ceilings": )" + ceilings + R"(, "so_that": )" + so_that + "}}";
  return run_ceilings(parse_study(text, "study.json"), {});
}
const std::string kGeometric = R"("theory": "geometric")";

// Slope for an EE diameter on the sky: 4 s sqrt(-2 ln(1 - p)).
double slope_of_diameter(double angle, double share) {
  return angle / (4 * std::sqrt(-2 * std::log(1 - share)));
}

// The geometric theory depends on the slope alone: s^2 = (2 pi)^2 / 2 int f^2 S1 df over the moments.
TEST(Ceilings, OfOctavesAndLinesAreThoseOfTheClosedLaw) {
  const Ceilings all =
      found(kGeometric, R"({"f_min": "10 /m", "f_max": "160 /m", "exponents": [0.5, 2, 3.5]})",
            R"({"ee80_diameter": "<= 6 arcsec"})");
  const double slope = slope_of_diameter(6 * kArcsec, 0.8);
  ASSERT_EQ(all.octaves.size(), 7u);  // four octaves, half an octave apart
  EXPECT_NEAR(all.octaves.front().frequency, 10 * std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(all.octaves.back().frequency, 160 / std::sqrt(2.0), 1e-9);
  for (const OctaveCeiling& octave : all.octaves) {
    const double low = octave.frequency / std::sqrt(2.0), high = 2 * low;
    EXPECT_NEAR(octave.rms * pi * std::hypot(low, high) / slope, 1, 1e-6) << octave.frequency;
    EXPECT_NEAR(octave.profile_psd / (octave.rms * octave.rms / (high - low)), 1, 1e-12);
  }
  ASSERT_EQ(all.lines.size(), 3u);
  for (const LineCeiling& line : all.lines) {
    // S2 = c A f^-(B+1) for profiles A f^-B; slope variance per axis (2 pi)^2 / 2 int f^2 S2 2 pi f df.
    const double b = line.exponent,
                 c = std::tgamma(0.5 * (b + 1)) / (2 * std::sqrt(pi) * std::tgamma(0.5 * b));
    const double amplitude = c * line.level * std::pow(1000.0, b);  // f in 1/m
    const double to = 3 - b, integral = (std::pow(160.0, to) - std::pow(10.0, to)) / to;
    EXPECT_NEAR(std::sqrt(4 * pi * pi * pi * amplitude * integral) / slope, 1, 1e-6) << b;
    const double heights = (std::pow(160.0, 1 - b) - std::pow(10.0, 1 - b)) / (1 - b);
    EXPECT_NEAR(std::sqrt(2 * pi * amplitude * heights) / line.rms, 1, 1e-6) << b;
    EXPECT_GT(line.headroom, 1) << "an octave alone has more than a share of it";
  }
}

// Fine roughness leaves a core of exp(-g^2) of the energy and scatters the rest outside the circle.
TEST(Ceilings, OfFineRoughnessLeaveTheCoreItsShare) {
  const double diameter = 4 * 500e-9 / 0.2;  // on the sky: v = pi D theta / lambda = 2 pi at the boundary
  const Ceilings all =
      found(R"("theory": "ghs")", R"({"f_min": "500 /m", "f_max": "1000 /m", "exponents": [2]})",
            fmt::format(R"({{"ee80_diameter": "<= {:.17g} rad"}})", diameter));
  const double v = 2 * pi;
  const double airy = 1 - std::pow(std::cyl_bessel_j(0.0, v), 2) - std::pow(std::cyl_bessel_j(1.0, v), 2);
  const double g = std::sqrt(std::log(airy / 0.8));
  for (const OctaveCeiling& octave : all.octaves)
    EXPECT_NEAR(4 * pi * octave.rms / 500e-9 / g, 1, 2e-4) << octave.frequency;
  ASSERT_EQ(all.lines.size(), 1u);
  EXPECT_NEAR(4 * pi * all.lines[0].rms / 500e-9 / g, 1, 2e-4);
}

TEST(Ceilings, LineOfADrawingUsesTheBudgetUp) {
  const std::string scene =
      R"("aberfit": 1, "mirror": {"focal_length": "2.4 m"}, "light": {"wavelength": "550 nm"},
      "aperture": {"shape": "annulus", "diameter": "1.2 m", "inner_diameter": "0.36 m"})";
  const Ceilings all = run_ceilings(
      parse_study(
          "{" + scene + R"(, "solve": {"ceilings": {"f_min": "1 /m", "f_max": "4 /m", "exponents": [2]},
          "so_that": {"ee80_radius": "<= 0.3 arcsec", "ee50_diameter": "<= 0.5 arcsec"}}})",
          "study.json"),
      {});
  ASSERT_EQ(all.lines.size(), 1u);
  const Study used = parse_study(
      "{" + scene +
          fmt::format(R"(, "roughness": {{"psd": {{"model": "power-law", "f_min": "1 /m", "f_max": "4 /m",
              "profile_psd": {{"A": {:.17g}, "f_unit": "1/mm", "B": 2}}}}}},
              "target": {{"statistics": {{"ee80": {{}}, "ee50": {{}}}}}}}})",
                      all.lines[0].level),
      "study.json");
  double used_up = 0;
  for (const Target& target : make_targets(used, lay_groundwork(used), 1).fitted) {
    const bool ee80 = statistic_name(target.statistic) == "ee80_radius_m";
    used_up = std::max(used_up, target.value / 2.4 / ((ee80 ? 0.3 : 0.25) * kArcsec));
  }
  EXPECT_NEAR(used_up, 1, 1e-6);
}

TEST(Ceilings, SayWhereThereAreNone) {
  const Ceilings none =
      found("", R"({"f_min": "20 /m", "f_max": "80 /m"})", R"({"ee80_diameter": "<= 0.1 arcsec"})");
  EXPECT_NE(none.reason.find("Airy"), std::string::npos) << none.reason;
  EXPECT_TRUE(none.lines.empty());
  // If the perfect mirror meets the budget, some height does, however strict the limit on 1 - exp(-g^2).
  const Ceilings strict =
      found(R"("theory": "ghs")", R"({"f_min": "20 /m", "f_max": "80 /m", "exponents": [2]})",
            R"({"tis": "<= 1e-9"})");
  ASSERT_EQ(strict.reason, "");
  for (const OctaveCeiling& octave : strict.octaves)
    EXPECT_NEAR(4 * pi * octave.rms / 500e-9 / std::sqrt(-std::log1p(-1e-9)), 1, 1e-6) << octave.frequency;
  // The height of an octave alone never reaches a metre in the searched range.
  const Ceilings any = found(kGeometric, R"({"f_min": "20 /m", "f_max": "80 /m", "exponents": [2]})",
                             R"({"rms_height": "<= 1 m"})");
  for (const OctaveCeiling& octave : any.octaves) {
    EXPECT_TRUE(std::isinf(octave.rms));
    EXPECT_FALSE(octave.reason.empty());
  }
  EXPECT_TRUE(std::isinf(any.lines[0].level));
  EXPECT_THROW(found(kGeometric, R"({"f_min": "20 /m", "f_max": "30 /m"})", R"({"rms_height": "<= 1 nm"})"),
               InputError);
}

}  // namespace
}  // namespace aberfit
