// Compares `solve` with published budgets.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/commands/run.h"
#include "aberfit/specify/solve.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

// Heights that are fine compared with the aperture, so that their correlation does not matter.
double allowed_rms(const std::string& mirror, const std::string& wavelength, const std::string& fineness,
                   const std::string& so_that) {
  const std::string study = fmt::format(
      R"({{"aberfit": 1, {}, "light": {{"wavelength": "{}"}},
          "roughness": {{"psd": {{"model": "gaussian", "rms": "{}", "correlation_length": "{}"}}}},
          "solve": {{"for": ["/roughness/psd/rms"], "so_that": {{{}}}}}}})",
      mirror, wavelength, wavelength == "3 mm" ? "50 um" : "20 nm", fineness, so_that);
  const Specification found = run_solve(parse_study(study, "study.json"), {});
  EXPECT_EQ(found.status, SolveStatus::kSolved) << so_that;
  return found.solutions.empty() ? 0 : found.solutions[0].at[0];
}

// Ruze, Antenna tolerance theory - a review, Proc. IEEE 54 (1966) 633: the gain of a shallow dish falls by
// 685.8 (rms/wavelength)^2 dB, one decibel at a surface RMS of lambda/26.2.
TEST(PublishedBudgets, OneDecibelOfAnAntennaIsRuzes) {
  const double rms = allowed_rms(
      R"("mirror": {"focal_length": "300 m"}, "aperture": {"shape": "circle", "diameter": "12 m"})", "3 mm",
      "5 cm", fmt::format(R"("strehl": ">= {:.12g}")", std::pow(10, -0.1)));
  EXPECT_NEAR(3e-3 / rms, 26.2, 0.03);
  EXPECT_NEAR(685.8 * std::pow(rms / 3e-3, 2), 1, 1e-3);
}

// The James Webb telescope is diffraction-limited at 2 um with a wavefront of 150 nm, Strehl 0.8 (Lightsey et
// al., Opt. Eng. 51 (2012) 011003). As fine roughness this is half of that on the surface of one mirror.
TEST(PublishedBudgets, DiffractionLimitOfTheWebbTelescope) {
  const double rms = allowed_rms(
      R"("mirror": {"focal_length": "131.4 m"}, "aperture": {"shape": "circle", "diameter": "6.5 m"})",
      "2 um", "3 cm", R"("strehl": ">= 0.8")");
  EXPECT_NEAR(2 * rms / 150e-9, 1, 5e-3);
}

// Bennett and Porteus, J. Opt. Soc. Am. 51 (1961) 123: TIS = (4 pi rms/wavelength)^2, 394 ppm at 1 nm, 632.8
// nm.
TEST(PublishedBudgets, ScatterOfASmoothMirrorIsBennettsAndPorteus) {
  const double rms =
      allowed_rms(R"("mirror": {"focal_length": "1 m"}, "aperture": {"shape": "circle", "diameter": "5 cm"})",
                  "632.8 nm", "0.2 mm", R"("tis": "<= 394.4e-6")");
  EXPECT_NEAR(rms / 1e-9, 1, 1e-3);
}

}  // namespace
}  // namespace aberfit
