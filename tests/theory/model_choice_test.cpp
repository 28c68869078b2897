#include "aberfit/theory/model_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "aberfit/theory/theory_error.h"
#include "short_form.h"

using namespace aberfit;
using std::numbers::pi;

namespace {

const Mirror kParabola{2.8, -1, {}};
constexpr double kLambda = 632.8e-9;
constexpr double kUsualAllowedError = 0.01 / 3;  // a third of the usual margin
constexpr double kWrong = 0.10;                  // error of a radius from which a chosen model is wrong

struct Family {
  const char* name;
  PsdModel model;  // rms 1 m, scaled to each g
};

std::vector<Family> families() {
  const double inf = std::numeric_limits<double>::infinity();
  return {{"gaussian", GaussianPsd{1, 3e-5}},
          {"k-correlation", KCorrelationPsd{1, 2e-4, 4.5, 0, inf}},
          {"sum", SumPsd{{GaussianPsd{1, 0.05}, GaussianPsd{0.1, 5e-3}}}},
          {"sum", SumPsd{{GaussianPsd{1, 0.05}, GaussianPsd{0.05, 5e-3}}}},
          {"sum", SumPsd{{GaussianPsd{1, 0.05}, GaussianPsd{0.03, 1.5e-3}}}},
          {"sum", SumPsd{{GaussianPsd{1, 0.3}, KCorrelationPsd{0.03, 0.02, 4.5, 0, inf}}}},
          {"sum", SumPsd{{GaussianPsd{1, 0.3}, KCorrelationPsd{0.1, 0.2, 4.2, 0, inf}}}},
          {"gaussian", GaussianPsd{1, 1e-3}},
          {"gaussian", GaussianPsd{1, 1e-2}},
          {"gaussian", GaussianPsd{1, 5e-2}},
          {"gaussian", GaussianPsd{1, 0.3}},
          {"uniform", UniformPsd{1, 2.5, 39.92}},
          {"uniform", UniformPsd{1, 0.5, 5}},
          {"uniform", UniformPsd{1, 20, 400}},
          {"k-correlation", KCorrelationPsd{1, 0.06, 5, 0, inf}},
          {"k-correlation", KCorrelationPsd{1, 0.5, 8, 0, inf}},
          {"k-correlation", KCorrelationPsd{1, 0.1, 4.5, 0, inf}},
          {"power law", PowerLawPsd{1, {}, 2.5, 2.5, 100}},
          {"power law", PowerLawPsd{1, {}, 4.0, 1, 100}}};
}

}  // namespace

// If the choice takes rays, their error in encircled energy is at most 1.5 times the allowed one, at
// fractions and planes between those of the choice. The choice must also take rays in some scenes.
TEST_WITH_SHORT_FORM(ModelChoice, TakesRaysOnlyWhereTheyAreTrueOfLight) {
  constexpr double kAllowed = 0.01;
  int by_rays = 0, by_waves = 0;
  double worst = 0;
  int scene = 0;
  for (const double diameter : {0.4, 0.08})
    for (const Family& family : families())
      for (const double g : {0.05, 0.2, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0}) {
        if (!whole && ++scene % 3 != 0) continue;
        const RadialPsd psd = RadialPsd(family.model).scaled(g * kLambda / (4 * pi));
        const Aperture aperture = CircleAperture{diameter};
        const ModelChoice choice = choose_model(psd, kParabola, aperture, kLambda, kAllowed);
        EXPECT_EQ(choice.reason.back(), '.');
        EXPECT_EQ(choice.model == FocusModel::kRays, choice.ray_error <= kAllowed);
        if (choice.model != FocusModel::kRays) {
          ++by_waves;
          // The radii show it too, unless the error is in encircled energies alone or in another plane.
          continue;
        }
        ++by_rays;
        const GeneralisedHarveyShack light(psd, kParabola, aperture, kLambda);
        const GeometricHarveyShack rays(kParabola, aperture, psd_moments(psd).rms_slope_per_axis(),
                                        Convention::kPhysical, 0);
        const double depth = kParabola.focal_length * choice.errors.ghs.ee90 / 2.146 / (0.5 * diameter);
        std::vector<double> planes = {0};
        if (5 * depth < 0.25 * kParabola.focal_length) planes = {0, 0.5 * depth, -1.75 * depth, 3.7 * depth};
        worst = std::max(worst,
                         ray_error_in_light(light, rays, {0.275, 0.425, 0.575, 0.725, 0.85, 0.925}, planes));
      }
  std::printf("  chosen: rays %d, waves %d; worst error of rays in between %.3g, allowed %.3g\n", by_rays,
              by_waves, worst, kAllowed);
  EXPECT_LE(worst, 1.5 * kAllowed);
  EXPECT_GT(by_rays, whole ? 20 : 5);
  EXPECT_GT(by_waves, whole ? 20 : 5);
}

TEST(ModelChoice, SaysWhyWhereModelsDoNotExist) {
  const Aperture circle = CircleAperture{0.4};
  const ModelChoice steep = choose_model(RadialPsd(KCorrelationPsd{1e-7, 0.1, 3.0}), kParabola, circle,
                                         kLambda, kUsualAllowedError);
  EXPECT_EQ(steep.model, FocusModel::kWaves);
  EXPECT_TRUE(std::isinf(steep.errors.ray_ee90));
  EXPECT_GT(steep.errors.ghs.ee90, 0);
  const ModelChoice endless = choose_model(RadialPsd(PowerLawPsd{{}, 1e-20, 4.0, 0, 100}), kParabola, circle,
                                           kLambda, kUsualAllowedError);
  EXPECT_EQ(endless.model, FocusModel::kWaves);
  EXPECT_TRUE(std::isnan(endless.errors.ray_ee90));
  EXPECT_NE(endless.reason.find("infinite"), std::string::npos);
}

TEST(ModelChoice, OfADivergentVarianceComesFromTheStructureFunction) {
  const Aperture circle = CircleAperture{0.4};
  const ModelChoice choice = choose_model(RadialPsd(PowerLawPsd{{}, 1e-20, 3.0, 0, 100}), kParabola, circle,
                                          kLambda, kUsualAllowedError);
  EXPECT_EQ(choice.model, FocusModel::kWaves);
  EXPECT_GT(choice.errors.ghs.ee90, 0);
  EXPECT_GT(choice.ray_error, kUsualAllowedError);
  EXPECT_NE(choice.reason.find("wave optics is needed"), std::string::npos);
}

ModelErrors errors_of(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                      double wavelength) {
  return choose_model(psd, mirror, aperture, wavelength, kUsualAllowedError).errors;
}

TEST(ModelChoice, KnowsTheMirrorAndTheApertureItIsAskedFor) {
  const RadialPsd psd(GaussianPsd{2e-8, 0.02});
  const Aperture square = PolygonAperture{{{-0.1, -0.1}, {0.1, -0.1}, {0.1, 0.1}, {-0.1, 0.1}}};
  const ModelErrors polygon = errors_of(psd, kParabola, square, kLambda);
  const ModelErrors rectangle = errors_of(psd, kParabola, RectangleAperture{0.2, 0.2}, kLambda);
  constexpr double kMean = 1e-4;  // error of the mean over azimuth
  EXPECT_NEAR(polygon.ghs.ee50 / rectangle.ghs.ee50, 1, kMean);
  EXPECT_NEAR(polygon.ghs.ee90 / rectangle.ghs.ee90, 1, kMean);
  EXPECT_NEAR(polygon.rays.ee90 / rectangle.rays.ee90, 1, kMean);
  // The aperture is not the circle of equal area, and a sphere is not a parabola.
  const Aperture circle = CircleAperture{2 * std::sqrt(0.04 / pi)};
  const ModelErrors round = errors_of(psd, kParabola, circle, kLambda);
  EXPECT_GT(std::abs(polygon.ghs.ee50 / round.ghs.ee50 - 1), 0.01);
  EXPECT_GT(errors_of(psd, Mirror{1.0, 0, {}}, circle, kLambda).ghs.ee50,
            3 * errors_of(psd, Mirror{1.0, -1, {}}, circle, kLambda).ghs.ee50);
}
