#include "aberfit/theory/model_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

using namespace aberfit;
using std::numbers::pi;

namespace {

const Mirror kParabola{2.8, -1, {}};
constexpr double kLambda = 632.8e-9;
constexpr double kWrong = 0.10;  // error of a radius above which a chosen model is wrong

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

struct Rule {
  const char* name;
  int scenes = 0, wrong90 = 0, wrong50 = 0;
  double worst = 0;
  void count(double error50, double error90) {
    ++scenes;
    wrong50 += !(std::abs(error50) <= kWrong);
    wrong90 += !(std::abs(error90) <= kWrong);
    worst = std::max({worst, std::abs(error50), std::abs(error90)});
  }
};

}  // namespace

TEST(ModelChoice, IsNeverWrongWhereTheOlderRulesAre) {
  // 14 g, 19 PSDs, f/7 and f/35: 532 scenes. Columns: share of all scenes in which the chosen model misses
  // GHS by more than 10 %. A rule that answers "GHS" is right by definition.
  Rule r10{"R >= 10"}, r1000{"R >= 1000"}, kappa{"kappa >= 0.85"}, numbers{"PHYSICS 7 thresholds"},
      choice{"choose_model"};
  int by_rays = 0, by_waves = 0, beyond1000 = 0, wrong_beyond1000 = 0;
  for (const double diameter : {0.4, 0.08})
    for (const Family& family : families())
      for (const double g : {0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0}) {
        const RadialPsd psd = RadialPsd(family.model).scaled(g * kLambda / (4 * pi));
        const Aperture aperture = CircleAperture{diameter};
        const SceneNumbers scene = scene_numbers(psd, kParabola, aperture, kLambda);
        const ModelChoice chosen_model = choose_model(psd, kParabola, aperture, kLambda);
        const ModelErrors& e = chosen_model.errors;
        const auto rays_if = [&](Rule& rule, bool rays) {
          rule.count(rays ? e.ray_ee50 : 0, rays ? e.ray_ee90 : 0);
        };
        rays_if(r10, scene.paper_ratio_r >= 10);
        rays_if(r1000, scene.paper_ratio_r >= 1000);
        rays_if(kappa, scene.kappa >= kKappaOfRays);
        if (scene.paper_ratio_r >= 1000) ++beyond1000, wrong_beyond1000 += std::abs(e.ray_ee90) > kWrong;
        rays_if(numbers, scene.rays_are_valid);
        const bool rays_chosen = chosen_model.model == FocusModel::kRays;
        rays_if(choice, rays_chosen);
        ++(rays_chosen ? by_rays : by_waves);
        if (scene.rays_are_valid != rays_chosen)
          std::printf("  moved: %s D %.2f g %g kappa %.3f: %s\n", family.name, diameter, g, scene.kappa,
                      chosen_model.reason.c_str());
        EXPECT_EQ(chosen_model.reason.back(), '.');
      }
  for (const Rule* rule : {&r10, &r1000, &kappa, &numbers, &choice})
    std::printf("  %-22s %d scenes, ee90 wrong %5.1f %%, ee50 wrong %5.1f %%, worst error %.3g\n", rule->name,
                rule->scenes, 100.0 * rule->wrong90 / rule->scenes, 100.0 * rule->wrong50 / rule->scenes,
                rule->worst);
  std::printf("  of %d scenes with R >= 1000 ray ee90 is wrong in %d; chosen: rays %d, waves %d\n",
              beyond1000, wrong_beyond1000, by_rays, by_waves);
  EXPECT_GE(choice.scenes, 200);
  EXPECT_EQ(choice.wrong90, 0);
  EXPECT_EQ(choice.wrong50, 0);
  EXPECT_GT(r10.wrong90, 0);  // what the rule is better than
  EXPECT_GT(r1000.wrong90, 0);
  EXPECT_GT(kappa.wrong90, 0);
  EXPECT_GT(by_rays, 20);  // and not by never trusting rays
  EXPECT_GT(by_waves, 5);  // nor by always trusting them
}

TEST(ModelChoice, SaysWhyWhereModelsDoNotExist) {
  const Aperture circle = CircleAperture{0.4};
  const ModelChoice steep =
      choose_model(RadialPsd(KCorrelationPsd{1e-7, 0.1, 3.0}), kParabola, circle, kLambda);
  EXPECT_EQ(steep.model, FocusModel::kWaves);
  EXPECT_TRUE(std::isinf(steep.errors.ray_ee90));
  EXPECT_GT(steep.errors.ghs.ee90, 0);
  const ModelChoice endless =
      choose_model(RadialPsd(PowerLawPsd{{}, 1e-20, 4.0, 0, 100}), kParabola, circle, kLambda);
  EXPECT_EQ(endless.model, FocusModel::kWaves);
  EXPECT_TRUE(std::isnan(endless.errors.ray_ee90));
  EXPECT_NE(endless.reason.find("infinite"), std::string::npos);
}

TEST(ModelChoice, OfADivergentVarianceComesFromTheStructureFunction) {
  const Aperture circle = CircleAperture{0.4};
  const ModelChoice choice =
      choose_model(RadialPsd(PowerLawPsd{{}, 1e-20, 3.0, 0, 100}), kParabola, circle, kLambda);
  EXPECT_EQ(choice.model, FocusModel::kWaves);
  EXPECT_GT(choice.errors.ghs.ee90, 0);
  EXPECT_NE(choice.reason.find("infinite"), std::string::npos);
}

TEST(ModelChoice, KnowsTheMirrorAndTheApertureItIsAskedFor) {
  const RadialPsd psd(GaussianPsd{2e-8, 0.02});
  const Aperture square = PolygonAperture{{{-0.1, -0.1}, {0.1, -0.1}, {0.1, 0.1}, {-0.1, 0.1}}};
  const ModelErrors polygon = model_errors(psd, kParabola, square, kLambda);
  const ModelErrors rectangle = model_errors(psd, kParabola, RectangleAperture{0.2, 0.2}, kLambda);
  constexpr double kMean = 1e-4;  // of the mean over azimuth
  EXPECT_NEAR(polygon.ghs.ee50 / rectangle.ghs.ee50, 1, kMean);
  EXPECT_NEAR(polygon.ghs.ee90 / rectangle.ghs.ee90, 1, kMean);
  EXPECT_NEAR(polygon.rays.ee90 / rectangle.rays.ee90, 1, kMean);
  // Not the circle of its area, and a sphere not a parabola.
  const Aperture circle = CircleAperture{2 * std::sqrt(0.04 / pi)};
  const ModelErrors round = model_errors(psd, kParabola, circle, kLambda);
  EXPECT_GT(std::abs(polygon.ghs.ee50 / round.ghs.ee50 - 1), 0.01);
  EXPECT_GT(model_errors(psd, Mirror{1.0, 0, {}}, circle, kLambda).ghs.ee50,
            3 * model_errors(psd, Mirror{1.0, -1, {}}, circle, kLambda).ghs.ee50);
}
