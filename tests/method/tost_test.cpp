#include "aberfit/method/tost.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "aberfit/core/random.h"
#include "aberfit/method/judged_set.h"

using namespace aberfit;

namespace {

constexpr double kQuantile95 = 1.6448536269514722;  // Phi^-1(0.95), tables
constexpr double kQuantile99 = 2.3263478740408408;  // Phi^-1(0.99)
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

EquivalenceMetric judge(double target, double target_error, double model, double model_error,
                        double margin = 0.01, double confidence = 0.95) {
  return tost("ee90_radius_m", false, target, target_error, model, model_error, margin, confidence);
}

}  // namespace

TEST(Tost, IntervalIsTheNormalQuantileTimesTheErrorOfTheRatio) {
  const EquivalenceMetric metric = judge(80e-6, 0.4e-6, 81e-6, 0.3e-6, 0.05, 0.99);
  const double error = std::sqrt(std::pow(0.3 / 80.0, 2) + std::pow(81.0 / 80.0 * 0.4 / 80.0, 2));
  constexpr double kRounding = 1e-15;  // a handful of operations on numbers of order 0.01
  EXPECT_NEAR(metric.relative_difference, 0.0125, kRounding);
  EXPECT_NEAR(metric.standard_error, error, kRounding);
  EXPECT_NEAR(metric.interval[0], 0.0125 - kQuantile99 * error, kRounding);
  EXPECT_NEAR(metric.interval[1], 0.0125 + kQuantile99 * error, kRounding);
  EXPECT_EQ(metric.verdict, Verdict::kEquivalent);
  EXPECT_EQ(metric.name, "ee90_radius_m");
  EXPECT_EQ(metric.margin, 0.05);
  EXPECT_EQ(metric.target, 80e-6);
  EXPECT_EQ(metric.model, 81e-6);
}

// Student's t at 0.95 from tables: 1.895 for 7 degrees of freedom, 1.753 for 15 (Abramowitz & Stegun 26.10;
// more digits from the closed form for odd degrees).
TEST(Tost, AnErrorFromAFewSamplesTakesStudentsT) {
  constexpr double kT7 = 1.894578605090006, kT15 = 1.7530503556925727, kRounding = 1e-12;
  EXPECT_NEAR(student_quantile(0.95, 7), kT7, kRounding);
  EXPECT_NEAR(student_quantile(0.95, 15), kT15, kRounding);
  EXPECT_NEAR(student_quantile(0.95, kInfinity), kQuantile95, kRounding);
  EXPECT_NEAR(student_quantile(0.95, 1), std::tan(0.45 * std::acos(-1.0)), kRounding);  // Cauchy
  const auto reach = [](double target_error, double model_error, const DegreesOfFreedom& freedom) {
    const EquivalenceMetric metric =
        tost("ee90_radius_m", false, 1.0, target_error, 1.0, model_error, 0.01, 0.95, freedom);
    return 0.5 * (metric.interval[1] - metric.interval[0]);
  };
  EXPECT_NEAR(reach(0, 0.001, {kInfinity, 7}), 0.001 * kT7, kRounding);
  EXPECT_NEAR(reach(0.001, 0, {15, 7}), 0.001 * kT15, kRounding);
  EXPECT_NEAR(reach(0, 0.001, {}), 0.001 * kQuantile95, kRounding);
  // Welch and Satterthwaite for errors 3 and 4: 625/(81/15 + 256/7), with 25 = 9 + 16.
  const double together = 625.0 / (81.0 / 15 + 256.0 / 7);
  EXPECT_NEAR(effective_degrees_of_freedom(3, 15, 4, 7), together, kRounding);
  EXPECT_NEAR(reach(0.003, 0.004, {15, 7}), 0.005 * student_quantile(0.95, together), kRounding);
  // Equal errors with equal degrees of freedom have the sum of both; a known error raises those of the other.
  EXPECT_NEAR(effective_degrees_of_freedom(2, 7, 2, 7), 14, kRounding);
  EXPECT_NEAR(effective_degrees_of_freedom(2, kInfinity, 2, 7), 28, kRounding);
  EXPECT_EQ(effective_degrees_of_freedom(0, 7, 0, 7), kInfinity);
}

TEST(Tost, VerdictFlipsWhereTheIntervalTouchesTheMargin) {
  const double margin = 0.01, error = 0.001, reach = kQuantile95 * error, nudge = 1e-9;
  const auto verdict = [&](double difference) {
    return judge(1.0, 0.0, 1.0 + difference, error, margin).verdict;
  };
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_EQ(verdict(sign * (margin - reach - nudge)), Verdict::kEquivalent);
    EXPECT_EQ(verdict(sign * (margin - reach + nudge)), Verdict::kUndecided);
    EXPECT_EQ(verdict(sign * margin), Verdict::kUndecided);
    EXPECT_EQ(verdict(sign * (margin + reach - nudge)), Verdict::kUndecided);
    EXPECT_EQ(verdict(sign * (margin + reach + nudge)), Verdict::kDifferent);
  }
}

TEST(Tost, WideIntervalProvesNothing) { EXPECT_EQ(judge(1.0, 0.2, 1.0, 0.2).verdict, Verdict::kUndecided); }

TEST(Tost, ExactNumbersAreEquivalentOrDifferentButNeverUndecided) {
  EXPECT_EQ(judge(2.0, 0.0, 2.015, 0.0, 0.01).verdict, Verdict::kEquivalent);
  EXPECT_EQ(judge(2.0, 0.0, 2.025, 0.0, 0.01).verdict, Verdict::kDifferent);
  EXPECT_EQ(judge(2.0, 0.0, 1.975, 0.0, 0.01).verdict, Verdict::kDifferent);
  EXPECT_EQ(judge(2.0, 0.0, 2.0, 0.0, 0.0).verdict, Verdict::kEquivalent);
  EXPECT_EQ(judge(2.0, 0.0, 2.0, 0.0).interval[1], 0.0);
}

TEST(Tost, WhatIsNotANumberIsDifferent) {
  EXPECT_EQ(judge(kNaN, 0.0, 1.0, 0.0).verdict, Verdict::kDifferent);
  EXPECT_EQ(judge(1.0, 0.0, kNaN, 0.0).verdict, Verdict::kDifferent);
  EXPECT_EQ(judge(kNaN, 0.1, kNaN, 0.1).verdict, Verdict::kDifferent);
  EXPECT_EQ(judge(1.0, 0.0, kInfinity, 0.0).verdict, Verdict::kDifferent);
  EXPECT_EQ(judge(0.0, 0.0, 1e-6, 0.0).verdict, Verdict::kDifferent);
}

TEST(Tost, ZeroTargetMetByZeroModelIsNoDifference) {
  EXPECT_EQ(judge(0.0, 0.0, 0.0, 0.0).verdict, Verdict::kEquivalent);
  EXPECT_EQ(judge(0.0, 0.0, 0.0, 1e-6).verdict, Verdict::kUndecided);
}

TEST(Tost, UnknownStandardErrorLeavesTheVerdictOpen) {
  EXPECT_EQ(judge(1.0, kNaN, 1.0, 0.0).verdict, Verdict::kUndecided);
  EXPECT_EQ(judge(1.0, 0.0, 1.0, kNaN).verdict, Verdict::kUndecided);
}

TEST(Tost, DoesNotDependOnTheUnitOfTheStatistic) {
  const EquivalenceMetric metres = judge(80e-6, 0.4e-6, 80.2e-6, 0.3e-6);
  const EquivalenceMetric other = judge(-80.0, 0.4, -80.2, 0.3);
  EXPECT_NEAR(metres.relative_difference, other.relative_difference, 1e-15);
  EXPECT_NEAR(metres.interval[0], other.interval[0], 1e-15);
  EXPECT_NEAR(metres.interval[1], other.interval[1], 1e-15);
}

// A difference of exactly one margin is called equivalent in 1 - confidence of all experiments.
TEST(Tost, DeclaresEquivalenceAtTheMarginAsOftenAsItsConfidenceAllows) {
  constexpr int kExperiments = 200000;
  const double margin = 0.01, model_error = 1.2e-3, target_error = 0.9e-3;
  for (const double sign : {-1.0, 1.0}) {
    const RandomStream noise(1, sign < 0 ? "tost-margin-below" : "tost-margin-above");
    int equivalent = 0;
    for (int i = 0; i < kExperiments; ++i) {
      const auto [a, b] = noise.normal_pair(std::uint64_t(i));
      const double target = 1.0 + target_error * a, model = 1.0 + sign * margin + model_error * b;
      if (judge(target, target_error, model, model_error, margin).verdict == Verdict::kEquivalent)
        ++equivalent;
    }
    const double rate = double(equivalent) / kExperiments;
    // The binomial error is sqrt(0.05 0.95 / 200000) = 4.9e-4; four of them are allowed. The second order of
    // the ratio moves z by 0.01, and the rate by 1e-3.
    EXPECT_NEAR(rate, 0.05, 4 * 4.9e-4 + 1e-3);
  }
}

TEST(Tost, CallsIdenticalTruthsEquivalentWhenTheErrorsAreSmall) {
  constexpr int kExperiments = 20000;
  const RandomStream noise(1, "tost-identical");
  int equivalent = 0;
  for (int i = 0; i < kExperiments; ++i) {
    const auto [a, b] = noise.normal_pair(std::uint64_t(i));
    if (judge(1.0 + 2e-3 * a, 2e-3, 1.0 + 2e-3 * b, 2e-3).verdict == Verdict::kEquivalent) ++equivalent;
  }
  // Power = P(|d| < margin - 1.645 se) with se = 2.828e-3: 2 Phi((0.01 - 4.652e-3)/2.828e-3) - 1.
  const double expected =
      std::erf((0.01 - kQuantile95 * std::sqrt(2.0) * 2e-3) / (std::sqrt(2.0) * 2e-3) / std::sqrt(2.0));
  EXPECT_NEAR(double(equivalent) / kExperiments, expected,
              4 * std::sqrt(expected * (1 - expected) / kExperiments) + 1e-3);
}

TEST(OverallVerdict, IsTheWorstOfItsMetrics) {
  EquivalenceMetric good, open, bad;
  good.verdict = Verdict::kEquivalent;
  open.verdict = Verdict::kUndecided;
  bad.verdict = Verdict::kDifferent;
  EXPECT_EQ(overall({good, good}), Verdict::kEquivalent);
  EXPECT_EQ(overall({good, open, good}), Verdict::kUndecided);
  EXPECT_EQ(overall({open, good, bad, good}), Verdict::kDifferent);
  EXPECT_EQ(overall({}), Verdict::kUndecided);
}

TEST(Verdict, HasTheWordsOfTheResultFormat) {
  EXPECT_EQ(to_string(Verdict::kEquivalent), "equivalent");
  EXPECT_EQ(to_string(Verdict::kDifferent), "different");
  EXPECT_EQ(to_string(Verdict::kUndecided), "undecided");
}

namespace {

// ee80 of a Gaussian spot of 10 um per axis: r dE/dr = 2 (1 - p) ln(1/(1 - p)) = 0.644.
Target gaussian_ee80() {
  Target target;
  target.statistic = EncircledEnergyRadius{0.8, 0};
  target.value = 10e-6 * std::sqrt(2 * std::log(5.0));
  target.tolerance = 1e-3 * target.value;
  target.curve_slope = gaussian_curve_slope(0.8);
  return target;
}
double gaussian_share(double radius, double sigma) { return -std::expm1(-0.5 * std::pow(radius / sigma, 2)); }

}  // namespace

TEST(JudgeInLight, IsTheRadiusWhereTheCurveIsSteep) {
  const Target target = gaussian_ee80();
  EXPECT_NEAR(*target.curve_slope, 2 * 0.2 * std::log(5.0), 1e-14);
  // For a spot 0.4 % larger, E(r_p) falls by 0.004 r dE/dr to first order.
  const double share = gaussian_share(target.value, 10.04e-6);
  const EquivalenceMetric metric = judge_target(target, false, 1.004 * target.value, share, 0, 0.01, 0.95);
  EXPECT_NEAR(metric.share_difference, share - 0.8, 1e-15);
  EXPECT_NEAR(metric.tolerance_share, 0.01 * *target.curve_slope, 1e-15);
  EXPECT_NEAR(metric.difference, 0.004, 1e-4);
  EXPECT_NEAR(metric.relative_difference, 0.004, 1e-12);
  EXPECT_EQ(metric.verdict, Verdict::kEquivalent);
  // 1.4 % larger is different by both measures.
  const double far = gaussian_share(target.value, 10.14e-6);
  EXPECT_EQ(judge_target(target, false, 1.014 * target.value, far, 0, 0.01, 0.95).verdict,
            Verdict::kDifferent);
}

TEST(JudgeInLight, IsAShareOfTheLightWhereTheCurveIsFlat) {
  Target target = gaussian_ee80();
  target.curve_slope = 0.05;  // between core and halo
  // A radius 4 % off is 0.2 % of the energy there, within the 0.35 % for a margin of 1 %.
  const EquivalenceMetric good = judge_target(target, false, 1.04 * target.value, 0.798, 0, 0.01, 0.95);
  EXPECT_NEAR(good.tolerance_share, 0.0035, 1e-15);
  EXPECT_NEAR(good.difference, 0.002 / 0.35, 1e-12);
  EXPECT_EQ(good.verdict, Verdict::kEquivalent);
  EXPECT_EQ(judge_target(target, false, target.value, 0.796, 0, 0.01, 0.95).verdict, Verdict::kDifferent);
  // A standard error of 0.1 % of the energy extends the 90 % interval beyond the margin.
  EXPECT_EQ(judge_target(target, false, target.value, 0.798, 1e-3, 0.01, 0.95).verdict, Verdict::kUndecided);
}

TEST(JudgeInLight, LeavesOtherStatisticsToTheirOwnUnit) {
  Target target;
  target.statistic = RingFwhm{};
  target.value = 3e-3;
  const EquivalenceMetric metric = judge_target(target, true, 3.015e-3, 3.015e-3, 0, 0.01, 0.95);
  EXPECT_NEAR(metric.difference, 0.005, 1e-12);
  EXPECT_TRUE(std::isnan(metric.tolerance_share));
  EXPECT_TRUE(metric.held_out);
}

TEST(JudgeInLight, ToleranceAndStandardErrorOfAnAimAreTheRadiusesInLight) {
  Target target = gaussian_ee80();
  target.standard_error = 2e-3 * target.value;
  const Target aim = aim_of(target);
  EXPECT_EQ(std::get<RingThrough>(aim.statistic).ring_radius, target.value);
  EXPECT_EQ(aim.value, 0.8);
  EXPECT_NEAR(aim.tolerance, 1e-3 * *target.curve_slope, 1e-15);
  EXPECT_NEAR(aim.standard_error, 2e-3 * *target.curve_slope, 1e-15);
  target.curve_slope.reset();
  EXPECT_EQ(aim_of(target).statistic.index(), target.statistic.index());
}

TEST(ModelError, WidensTheIntervalToBothSides) {
  const EquivalenceMetric sharp = judge(1.0, 0, 1.006, 0);
  EXPECT_EQ(sharp.verdict, Verdict::kEquivalent);
  const EquivalenceMetric wide = with_model_error(sharp, 0.005);
  EXPECT_NEAR(wide.interval[0], 0.001, 1e-12);
  EXPECT_NEAR(wide.interval[1], 0.011, 1e-12);
  EXPECT_EQ(wide.verdict, Verdict::kUndecided);
  EXPECT_EQ(with_model_error(judge(1.0, 0, 1.02, 0), 0.005).verdict, Verdict::kDifferent);
  EXPECT_EQ(with_model_error(sharp, 0.003).verdict, Verdict::kEquivalent);
}

// The difference is known to lie within the model's error of the edge; no number of samples decides it.
TEST(Tost, SamplesDecideNothingThatTheModelsErrorLeavesOpen) {
  const auto open = [](double difference, double standard_error) {
    return with_model_error(judge(1.0, 0, 1 + difference, standard_error), 0.003);
  };
  ASSERT_EQ(open(0.009, 1e-5).verdict, Verdict::kUndecided);
  for (const double difference : {0.008, 0.009, 0.012, -0.012}) {
    EXPECT_FALSE(more_samples_could_decide(open(difference, 1e-5))) << difference;
    ASSERT_EQ(open(difference, 0.005).verdict, Verdict::kUndecided);
    EXPECT_TRUE(more_samples_could_decide(open(difference, 0.005))) << difference;
  }
  ASSERT_EQ(open(0.006, 0.001).verdict, Verdict::kUndecided);
  EXPECT_TRUE(more_samples_could_decide(open(0.006, 0.001)));
  // A model error of twice the margin never gives `equivalent`, even without sampling error.
  const EquivalenceMetric coarse = with_model_error(judge(1.0, 0, 1.0, 0.009), 0.02);
  ASSERT_EQ(coarse.verdict, Verdict::kUndecided);
  EXPECT_FALSE(more_samples_could_decide(coarse));
  EXPECT_FALSE(more_samples_could_decide(open(0.001, 1e-4)));  // equivalent
  EXPECT_FALSE(more_samples_could_decide(open(0.03, 1e-4)));   // different
}

namespace aberfit {

TEST(StrayLight, IsATightToleranceFarFromTheCore) {
  Target far;
  far.statistic = EncircledEnergyRadius{0.95, 0};
  far.value = 1e-4;
  far.curve_slope = 0.1;
  EquivalenceSpec asked;
  EXPECT_EQ(margin_of(far, asked), asked.margin);
  asked.stray_light = 0.02;
  const JudgedSet judged({far}, {});
  // 0.0015 below 0.95 is 3 % more energy outside, well within 1 % of max(r dE/dr, 0.35).
  const auto verdict = [&](double share) {
    FreshStatistics fresh;
    fresh.value = Eigen::Vector2d(1e-4, share);
    fresh.standard_error = Eigen::Vector2d::Zero();
    return judged.judge(fresh, asked).front();
  };
  EXPECT_EQ(verdict(0.95 - 0.0015).verdict, Verdict::kDifferent);
  EXPECT_EQ(verdict(0.95 - 0.0009).verdict, Verdict::kEquivalent);
  EXPECT_NEAR(verdict(0.95).tolerance_share, 0.02 * 0.05, 1e-15);
  asked.stray_light.reset();
  EXPECT_EQ(verdict(0.95 - 0.0015).verdict, Verdict::kEquivalent);
  // Near the core the margin is the closer limit.
  far.statistic = EncircledEnergyRadius{0.2, 0};
  asked.stray_light = 0.02;
  EXPECT_EQ(margin_of(far, asked), asked.margin);
}

}  // namespace aberfit
