// Several surfaces, air and motion: each against its own law.
#include "aberfit/specify/contributors.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

using std::numbers::pi;

const std::string kPsd =
    R"({"model": "k-correlation", "rms": "20 nm", "B": "0.1 m", "exponent": 2.8, "f_min": "5 /m", "f_max": "100 /m"})";

Specification solved(const std::string& with,
                     const std::string& so_that = R"({"ee80_diameter": "<= 2 arcsec"})") {
  return run_solve(
      parse_study(R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
          "aperture": {"shape": "circle", "diameter": "0.4 m"}, "roughness": {"psd": )" +
                      kPsd + R"(}, "solve": {"for": ["/roughness/psd/rms"], "so_that": )" + so_that +
                      (with.empty() ? "" : R"(, "with": )" + with) + "}}",
                  "study.json"),
      {});
}

const Eigen::ArrayXd kShears = Eigen::ArrayXd::LinSpaced(12, 0.01, 0.4);

TEST(Contributors, TwoEqualSurfacesAreOneOfSqrtTwo) {
  const Specification one = solved(""),
                      two = solved(R"({"surfaces": [{"name": "twin", "psd": )" + kPsd + "}]}");
  ASSERT_EQ(two.status, SolveStatus::kSolved);
  // The twin keeps its 20 nm: sqrt(sigma^2 + 20^2) is what one surface may have.
  EXPECT_NEAR(std::hypot(two.solutions[0].at[0], 20e-9) / one.solutions[0].at[0], 1, 1e-9);
  ASSERT_EQ(two.uses.size(), 2u);
  EXPECT_EQ(two.uses[0].name, "mirror");
  EXPECT_EQ(two.uses[1].name, "twin");
  EXPECT_DOUBLE_EQ(two.uses[0].alone[0], two.uses[1].without[0]);
  EXPECT_LT(two.uses[0].alone[0], two.budgets[0].limit);
  EXPECT_TRUE(one.uses.empty());
}

// D'(x) = cos^2 D(footprint x): a beam of a third of the width sees a third of the shear.
TEST(Contributors, BeamOnAnotherSurface) {
  PowerLawPsd by_amplitude;
  by_amplitude.amplitude = 1e-20;
  by_amplitude.exponent = 3;
  by_amplitude.f_min = 2;
  by_amplitude.f_max = 200;
  PowerLawPsd by_rms = by_amplitude;
  by_rms.amplitude.reset();
  by_rms.rms = 10e-9;
  const PsdModel models[] = {UniformPsd{20e-9, 5, 50},
                             KCorrelationPsd{20e-9, 0.1, 2.8, 5, 100},
                             by_amplitude,
                             by_rms,
                             GaussianPsd{20e-9, 0.03},
                             TablePsd{{5, 20, 80}, {1e-20, 3e-21, 1e-23}},
                             SumPsd{{UniformPsd{20e-9, 5, 50}, GaussianPsd{20e-9, 0.03}}}};
  for (const PsdModel& model : models) {
    const OtherSurface surface{"secondary", model, 0.3, 0.5, false};
    const Eigen::ArrayXd ours = structure_function(RadialPsd(in_pupil(surface)), kShears),
                         law =
                             std::pow(std::cos(0.5), 2) * structure_function(RadialPsd(model), 0.3 * kShears);
    EXPECT_LT((ours / law - 1).abs().maxCoeff(), 1e-9) << model.index();
    OtherSurface wavefront = surface;
    wavefront.is_wavefront = true;
    EXPECT_LT((structure_function(RadialPsd(in_pupil(wavefront)), kShears) / ours - 0.25).abs().maxCoeff(),
              1e-9);
  }
}

// Fried's 6.88 (x/r0)^(5/3) of the phase 4 pi h/lambda.
TEST(Contributors, AtmosphereIsKolmogorovs) {
  const Atmosphere air{0.15, 500e-9};
  const Eigen::ArrayXd phase =
      2 * std::pow(4 * pi / 500e-9, 2) * structure_function(RadialPsd(in_pupil(air)), kShears);
  EXPECT_LT((phase / (6.8838772 * (kShears / 0.15).pow(5.0 / 3)) - 1).abs().maxCoeff(), 1e-4);
}

// A Gaussian blur of the image: exp(-2 pi^2 jitter^2 x^2/lambda^2), at every wavelength.
TEST(Contributors, JitterIsAGaussianBlur) {
  const double jitter = 1e-6, lambda = 632.8e-9;
  const Eigen::ArrayXd exponent =
      std::pow(4 * pi / lambda, 2) * structure_function(RadialPsd(in_pupil_of_jitter(jitter, 0.4)), kShears);
  EXPECT_LT((exponent / (2 * pi * pi * (jitter * kShears / lambda).square()) - 1).abs().maxCoeff(), 1e-4);
}

// Strehl ratios of fine roughness multiply; what the air leaves is for the mirror.
TEST(Contributors, TakeTheirPartOfTheBudget) {
  const Specification
      alone = solved(""),
      shaken = solved(R"({"jitter": "0.3 arcsec", "atmosphere": {"r0": "40 cm", "wavelength": "500 nm"}})");
  ASSERT_EQ(shaken.status, SolveStatus::kSolved);
  EXPECT_LT(shaken.solutions[0].at[0], alone.solutions[0].at[0]);
  ASSERT_EQ(shaken.uses.size(), 3u);
  EXPECT_EQ(shaken.uses[1].name, "atmosphere");
  EXPECT_EQ(shaken.uses[2].name, "jitter");
  for (const BudgetUse& use : shaken.uses) {
    EXPECT_LT(use.alone[0], shaken.budgets[0].limit) << use.name;
    EXPECT_LT(use.without[0], shaken.budgets[0].limit) << use.name;
    EXPECT_GT(use.alone[0], shaken.perfect[0].value * (1 - 1e-9)) << use.name;
  }
  const Specification too_much = solved(R"({"jitter": "2 arcsec"})");
  EXPECT_EQ(too_much.status, SolveStatus::kNoSolution);
  EXPECT_THROW(solved(R"({"jitter": "0.3 arcsec"})", R"({"rms_height": "<= 20 nm"})"), InputError);
  // By slopes there is no path: those of turbulence have no variance.
  try {
    run_solve(parse_study(
                  R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
          "aperture": {"shape": "circle", "diameter": "0.4 m"}, "target": {"theory": "geometric"}, "roughness": {"psd": )" +
                      kPsd + R"(}, "solve": {"for": ["/roughness/psd/rms"], "so_that": {"ee80_diameter":
          "<= 2 arcsec"}, "with": {"jitter": "0.3 arcsec"}}})",
                  "study.json"),
              {});
    ADD_FAILURE() << "geometric";
  } catch (const InputError& error) {
    EXPECT_EQ(error.pointer(), "/target/theory");
  }
}

// Seeing of 0.976 lambda/r0, r0 as lambda^(6/5); an aperture of 40 r0 sharpens a long exposure's transfer
// function by little.
TEST(Contributors, WidthOfTheImageIsTheSeeing) {
  const Specification spec = run_solve(
      parse_study(R"({"aberfit": 1, "mirror": {"focal_length": "40 m"}, "light": {"wavelength": "632.8 nm"},
          "aperture": {"shape": "circle", "diameter": "4 m"}, "roughness": {"psd": {"model": "uniform", "rms": "20 nm",
          "f_min": "5 /m", "f_max": "20 /m"}}, "solve": {"for": ["/roughness/psd/rms"], "so_that": {
          "fwhm": "<= 1.5 arcsec"}, "with": {"atmosphere": {"r0": "10 cm", "wavelength": "500 nm"}}}})",
                  "study.json"),
      {});
  ASSERT_EQ(spec.uses.size(), 2u);
  EXPECT_EQ(spec.uses[1].name, "atmosphere");
  const double r0 = 0.1 * std::pow(632.8 / 500, 1.2);
  EXPECT_NEAR(spec.uses[1].alone[0] / (0.976 * 632.8e-9 / r0), 1, 0.02);
  for (const char* of_a_surface : {R"({"bsdf@5deg": "<= 1"})", R"({"rms_slope": "<= 1e-6"})"})
    EXPECT_THROW(solved(R"({"jitter": "0.3 arcsec"})", of_a_surface), InputError) << of_a_surface;
}

}  // namespace
}  // namespace aberfit
