// If one number of a study varies, nothing may jump: neither the targets of the theory nor the wave-optics
// verdict on the surfaces, even where the program changes from one model to another.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "aberfit/commands/run.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/study/read_study.h"
#include "reference_scenes.h"

namespace aberfit {
namespace {

using nlohmann::json;

constexpr int kSteps = 60, kFits = 12;

// One number varies from `low` to `high` in equal ratios.
struct Sweep {
  const char* name;
  double low, high;
  std::function<json(double)> study;
  double at(int k, int steps = kSteps) const { return low * std::pow(high / low, k / (steps - 1.0)); }
};

// The study with the statistics and terms for sweeps of targets.
json with_targets(json study) {
  // The planes are named, because by default they move with the spot in steps of a micrometre.
  const json radii{{"planes", {"0 mm", "-0.4 mm", "0.9 mm"}}};
  study["terms"] = {{"zernike", {{"n_max", 16}}}};
  study["target"] = {
      {"statistics",
       {{"ee20", radii}, {"ee50", radii}, {"ee80", radii}, {"ee90", radii}, {"ring_fwhm", json::object()}}}};
  return study;
}
json scene(double focal_length, const json& psd) {
  return with_targets(study_of(focal_length, circle(0.2), psd));
}
json uniform(double rms) { return {{"model", "uniform"}, {"rms", rms}, {"f_min", 5}, {"f_max", 20}}; }

std::vector<Sweep> sweeps() {
  return {
      {"sigma", 10e-9, 500e-9, [](double rms) { return scene(1.4, uniform(rms)); }},
      {"correlation length", 15e-3, 150e-3,
       [](double length) {
         return scene(1.4, {{"model", "gaussian"}, {"rms", 60e-9}, {"correlation_length", length}});
       }},
      {"f-number", 1.5, 20,
       [](double f_number) {
         json study = scene(0.2 * f_number, uniform(60e-9));
         for (auto& radius : study["target"]["statistics"])
           if (radius.contains("planes")) radius["planes"] = {"0 mm"};  // the others go as the square
         return study;
       }},
      // The README's mirror, of 118 modes. Below 0.3 % no surface is equivalent: at 0.1 % held-out statistics
      // stay wrong by 0.25 %. The mirror of the other sweeps, of 29 modes at 250 nm, stays wrong by 0.5 %.
      {"margin", 3e-3, 0.1, [](double margin) {
         json study = with_targets(readme_study());
         study["equivalence"]["margin"] = margin;
         return study;
       }}};
}

// Value at the middle of four neighbours at the distances -2, -1, 1, 2.
double interpolated(double a, double b, double c, double d) { return (4 * (b + c) - (a + d)) / 6; }

// One step of the sweep: its study, and the targets by theory with the curves they come from.
struct Step {
  Study study;
  Groundwork ground;
  TargetSets targets;
  Step(const Sweep& sweep, int k)
      : study(parse_study(sweep.study(sweep.at(k)).dump(), "sweep.json")),
        ground(lay_groundwork(study)),
        targets(make_targets(study, ground, 2)) {}
};

// Difference between a step's energy at its target radius and the one interpolated from the curves of its
// four neighbours, in units of what the study judges it by (PHYSICS 7). Differences of radii are no measure
// of this: between core and halo, where the spot is dark, a radius is ill-defined.
double departure(const Target& target, const std::array<const Step*, 4>& around) {
  std::array<double, 4> there;
  for (std::size_t n = 0; n < 4; ++n) {
    if (!around[n]->ground.mean_spot) return HUGE_VAL;  // another theory
    if (const auto* ee = std::get_if<EncircledEnergyRadius>(&target.statistic)) {
      const auto spot = around[n]->ground.mean_spot->at_plane(ee->dz);
      there[n] = spot.encircled_energy(target.value);
    } else {
      for (const Target& other : around[n]->targets.fitted)
        if (statistic_name(other.statistic) == statistic_name(target.statistic))
          there[n] = std::log(other.value / target.value);
    }
  }
  const double smooth = interpolated(there[0], there[1], there[2], there[3]);
  const auto* ee = std::get_if<EncircledEnergyRadius>(&target.statistic);
  // The ring is the ee90 of the step itself, which is ill-defined there.
  constexpr double kOfRing = 0.1;
  return ee ? std::abs(smooth - ee->fraction) / aim_of(target).relative_to() : kOfRing * std::abs(smooth);
}

double roughest_aim(const Sweep& sweep, int first, int last) {
  std::vector<Step> all;
  for (int k = first; k <= last; ++k) all.emplace_back(sweep, k);
  double worst = 0;
  for (std::size_t k = 2; k + 2 < all.size(); ++k)
    for (const Target& target : all[k].targets.fitted)
      worst = std::max(worst, departure(target, {&all[k - 2], &all[k - 1], &all[k + 1], &all[k + 2]}));
  return worst;
}

// A tenth of the margin of these studies. Half of it is the error of the interpolation where the core of the
// spot changes into its halo.
constexpr double kSmooth = 1e-3;

class Continuity : public testing::TestWithParam<int> {};
TEST_P(Continuity, OfTargets) {
  const Sweep sweep = sweeps()[std::size_t(GetParam())];
  const double worst = roughest_aim(sweep, 0, kSteps - 1);
  std::printf("targets along %s: steps within %.1e of their neighbours\n", sweep.name, worst);
  EXPECT_LE(worst, kSmooth) << sweep.name;
}

// Surfaces fitted at neighbouring steps, judged by waves, differ by no more than the margin allows.
TEST_P(Continuity, OfSurfacesInLight) {
  const Sweep sweep = sweeps()[std::size_t(GetParam())];
  std::vector<std::vector<double>> off;  // of every statistic, in margins
  int equivalent = 0;
  for (int k = 0; k < kFits; ++k) {
    const double value = sweep.at(k, kFits);
    json text = sweep.study(value);
    text.erase("target");  // all by default, held-out statistics too
    text["terms"] = "auto";
    const Study study = parse_study(text.dump(), "sweep.json");
    const ResultDocument result = run_fit(study, {});
    equivalent += result.judgement.verdict == Verdict::kEquivalent;
    if (result.judgement.verdict != Verdict::kEquivalent)
      std::printf("%s %.4g: %s\n", sweep.name, value, to_string(result.judgement.verdict).c_str());
    const auto& metrics = result.judgement.light && !result.judgement.light->metrics.empty()
                              ? result.judgement.light->metrics
                              : result.judgement.metrics;
    off.emplace_back();
    for (const EquivalenceMetric& metric : metrics) off.back().push_back(metric.difference / metric.margin);
  }
  double worst = 0;
  for (std::size_t k = 1; k + 1 < off.size(); ++k)
    for (std::size_t s = 0; s < std::min({off[k - 1].size(), off[k].size(), off[k + 1].size()}); ++s)
      worst = std::max(worst, std::abs(off[k][s] - 0.5 * (off[k - 1][s] + off[k + 1][s])));
  std::printf("surfaces along %s: steps within %.2f margins of their neighbours\n", sweep.name, worst);
  EXPECT_GE(equivalent, kFits - 1) << sweep.name;  // one seed in thirty fails
  EXPECT_LE(worst, 2.0) << sweep.name;             // each is within one of its target
}
INSTANTIATE_TEST_SUITE_P(Along, Continuity, testing::Range(0, 4));

// Twelve of the steps: near 70 nm, where a rule of thumb once changed the theory and ee90 fell by 7 %, and
// others that are quick.
TEST(ContinuitySmoke, OfTargets) {
  const std::vector<Sweep> all = sweeps();
  const int first[] = {24, 20, 0, 24};
  for (std::size_t k = 0; k < all.size(); ++k)
    EXPECT_LE(roughest_aim(all[k], first[k], first[k] + 11), kSmooth) << all[k].name;
}

}  // namespace
}  // namespace aberfit
