// The cut of a roughness into terms and scatter, and the statements about both parts.
#include "aberfit/method/band_choice.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/report/documents.h"
#include "aberfit/study/read_study.h"
#include "aberfit/theory/realisation_spread.h"
#include "short_form.h"

namespace aberfit {
namespace {

// A 0.3 m f/6 circle with a k-correlation PSD from 5 to `f_max` cycles/m. more: keys after a comma.
std::string scene(double rms_nm, double f_max = 400, const std::string& more = "", double f_min = 5) {
  return fmt::format(
      R"({{"aberfit": 1, "mirror": {{"focal_length": "1.8 m"}}, "aperture": {{"shape": "circle", )"
      R"("diameter": "0.3 m"}}, "light": {{"wavelength": "632.8 nm"}}, "roughness": {{"psd": {{"model": )"
      R"("k-correlation", "rms": "{} nm", "B": "40 mm", "exponent": 3, "f_min": "{} /m", "f_max": "{} /m"}}}}{}}})",
      rms_nm, f_min, f_max, more);
}

Layout layout_of(const std::string& text) { return lay_out(parse_study(text, "study.json"), 2); }

std::string refusal(const std::string& text) {
  try {
    layout_of(text);
  } catch (const FieldError& error) {
    return error.what();
  }
  return "";
}

// Largest standard deviation of a judged statistic over a third of its tolerance, by theory alone.
double spread_over_limit(const Study& study, const Layout& layout, double cut) {
  const double third = study.equivalence.margin / 3;
  std::vector<FocalDisc> discs;
  std::vector<double> limits;
  for (const auto* set : {&layout.targets.fitted, &layout.targets.held_out})
    for (const Target& target : *set)
      if (const auto* ee = std::get_if<EncircledEnergyRadius>(&target.statistic)) {
        discs.push_back({target.value, ee->dz});
        limits.push_back(third * std::max(*target.curve_slope, 0.35));
      }
  const RealisationSpread spread(
      {*layout.ground.psd, study.mirror, study.aperture, study.wavelength, *layout.ground.mean_spot}, discs,
      2);
  const Eigen::ArrayXd light = spread.light(cut);
  double worst = 0;
  for (std::size_t k = 0; k < limits.size(); ++k) worst = std::max(worst, light[Eigen::Index(k)] / limits[k]);
  return worst;
}

}  // namespace

TEST_WITH_SHORT_FORM(BandChoice, CutsWhereTheSpreadIsAThirdOfTheToleranceAndNoHigher) {
  for (const double rms : test::all_or_few(whole, std::vector{8.0, 25.0, 60.0}, {1})) {
    const Study study = parse_study(scene(rms), "study.json");
    const Layout layout = lay_out(study, 2);
    ASSERT_TRUE(layout.ground.split);
    const double cut = layout.ground.split->cut();
    ASSERT_GT(cut, 5);
    // Rings are judged, too, and may need a higher cut than the discs of this check.
    EXPECT_LE(spread_over_limit(study, layout, cut), 1 + 1e-6) << rms;
    EXPECT_NEAR(layout.ground.shares->spread, 1.0 / 3, 1e-6);
    if (layout.ground.shares->spread_of.find("ring") == std::string::npos) {
      EXPECT_GT(spread_over_limit(study, layout, 0.98 * cut), 1) << rms;
    }
  }
}

TEST_WITH_SHORT_FORM(BandChoice, ALargerMarginCutsLower) {
  double before = 1e9;
  for (const char* margin : test::all_or_few(whole, std::vector{"0.5 %", "1 %", "2 %", "4 %"}, {1, 2})) {
    const Layout layout =
        layout_of(scene(25, 400, fmt::format(R"(, "equivalence": {{"margin": "{}"}})", margin)));
    ASSERT_TRUE(layout.ground.split) << margin;
    EXPECT_LT(layout.ground.split->cut(), before) << margin;
    before = layout.ground.split->cut();
  }
}

TEST_WITH_SHORT_FORM(BandChoice, MovesSmoothlyAlongASweep) {
  std::vector<double> cuts;
  for (int k = 0; k < (whole ? 9 : 4); ++k) {
    const Layout layout = layout_of(scene(20 * std::pow(1.03, k)));
    ASSERT_TRUE(layout.ground.split);
    cuts.push_back(std::log(layout.ground.split->cut()));
  }
  // Each cut lies within 1 % of the line through its neighbours, a twentieth of a step.
  for (std::size_t k = 1; k + 1 < cuts.size(); ++k)
    EXPECT_NEAR(cuts[k], 0.5 * (cuts[k - 1] + cuts[k + 1]), 0.01) << k;
}

TEST(BandChoice, TheEndOfTheBandHardlyMattersToTheCut) {
  // With ten times the band, the additional frequencies scatter far away.
  const double narrow = layout_of(scene(15, 400)).ground.split->cut(),
               wide = layout_of(scene(15, 4000)).ground.split->cut();
  EXPECT_NEAR(wide / narrow, 1, 0.1);
}

TEST(BandChoice, NothingIsLostBetweenTheParts) {
  const Layout layout = layout_of(scene(25));
  const BandShares& shares = *layout.ground.shares;
  const PsdMoments all = psd_moments(*layout.ground.psd);
  EXPECT_NEAR(std::hypot(shares.low_rms, shares.rest_rms) / all.rms_height(), 1, 1e-10);
  EXPECT_NEAR(std::hypot(shares.low_slope, shares.rest_slope) / all.rms_slope_per_axis(), 1, 1e-10);
  EXPECT_NEAR(psd_moments(*layout.ground.prior_psd).rms_height() / shares.low_rms, 1, 1e-12);
  EXPECT_NE(shares.reason.find("cycles across"), std::string::npos) << shares.reason;
}

TEST(BandChoice, FollowsWhatTheStudySays) {
  EXPECT_FALSE(layout_of(scene(25, 400, R"(, "terms": {"band": "all"})")).ground.split);
  EXPECT_FALSE(layout_of(scene(25, 400, R"(, "terms": {"zernike": {"n_max": 12}})")).ground.split);
  EXPECT_TRUE(
      layout_of(scene(25, 400, R"(, "terms": {"zernike": {"n_max": 12}, "band": "auto"})")).ground.split);
  EXPECT_FALSE(layout_of(scene(25, 400, R"(, "target": {"theory": "geometric"})")).ground.split);
  const Layout named = layout_of(scene(25, 400, R"(, "terms": {"band": "33 /m"})"));
  ASSERT_TRUE(named.ground.split);
  EXPECT_EQ(named.ground.split->cut(), 33);
  EXPECT_FALSE(named.ground.shares->automatic);
  EXPECT_TRUE(parse_study(scene(25, 400, R"(, "terms": {"band": "33 /m"})"), "s").terms.automatic());
  // With a cut above the band everything is terms; with a cut below it, nothing is.
  EXPECT_FALSE(layout_of(scene(25, 400, R"(, "terms": {"band": "500 /m"})")).ground.split);
  EXPECT_FALSE(layout_of(scene(25, 400, R"(, "terms": {"band": "1 /m"})")).ground.split->has_low());
}

TEST(BandChoice, RefusesACutThatNoLightMultiplies) {
  for (const char* rays : {R"(, "terms": {"band": "33 /m"}, "target": {"convention": "paper"})",
                           R"(, "terms": {"band": "3 /m"}, "target": {"theory": "geometric"})"}) {
    const std::string why = refusal(scene(25, 400, rays));
    EXPECT_NE(why.find("terms.band"), std::string::npos) << rays << why;
  }
  const std::string mean = refusal(
      scene(25, 400,
            R"(, "terms": {"band": "33 /m"}, "target": {"statistics": {"scatter_mean": {}, "ee50": {}}})"));
  EXPECT_NE(mean.find("scatter_mean"), std::string::npos) << mean;
  EXPECT_FALSE(layout_of(scene(25, 400, R"(, "target": {"statistics": {"scatter_mean": {}, "ee50": {}}})"))
                   .ground.split);
  for (const char* band : {R"("-3 /m")", R"("some")", "0", R"("3 m")", "[1]"}) {
    EXPECT_THROW(layout_of(scene(25, 400, fmt::format(R"(, "terms": {{"band": {}}})", band))), InputError)
        << band;
  }
}

TEST(BandChoice, AFitShowsBothPartsAndRunsAgainFromItsResolvedStudy) {
  const Study study = parse_study(scene(25, 400, R"(, "equivalence": {"margin": "3 %"})"), "study.json");
  const ResultDocument result = run_fit(study, {});
  EXPECT_EQ(result.judgement.verdict, Verdict::kEquivalent);
  ASSERT_TRUE(result.band.shares && result.band.scatter);
  EXPECT_NEAR(std::hypot(result.fitted.surface.rms_height, result.band.shares->rest_rms), 25e-9,
              0.03 * 25e-9);
  // Both are averages over the aperture, whose rim is tilted by 1/24 at f/6.
  EXPECT_NEAR(result.band.scatter->table.tis, result.band.shares->tis, 5e-3 * result.band.shares->tis);
  const nlohmann::ordered_json json = to_json(result, resolved(study, result));
  EXPECT_EQ(json["split"]["cut_per_m"], result.band.shares->cut);
  EXPECT_EQ(json["study"]["terms"]["band"], result.band.shares->cut);
  const std::string table = text_of(page_of(result, true));
  EXPECT_NE(table.find("Band"), std::string::npos);
  const ResultDocument again = run_fit(parse_study(json["study"].dump(), "study.json"), {});
  ASSERT_EQ(again.fitted.terms.size(), result.fitted.terms.size());
  EXPECT_LT((again.fitted.fit.coefficients - result.fitted.fit.coefficients).norm(),
            1e-9 * result.fitted.fit.coefficients.norm());
}

// Under a theory of rays, scatter is an independent slope of each ray; wave optics is shown beside it.
TEST(BandChoice, RaysAreSplitWhereTheStudySaysAndTheirVerdictIsAboutTheWhole) {
  const std::string text =
      scene(250, 400,
            R"(, "terms": {"zernike": {"n_max": 12}, "band": "33 /m"}, "target": {"theory": "geometric"}, )"
            R"("equivalence": {"margin": "3 %"})");
  const Layout layout = layout_of(text);
  ASSERT_TRUE(layout.ground.split);
  EXPECT_EQ(layout.ground.use.model, FocusModel::kRays);
  EXPECT_EQ(layout.targets.theory, "geometric");
  EXPECT_NEAR(psd_moments(*layout.ground.prior_psd).rms_height(), layout.ground.shares->low_rms, 1e-15);
  const ResultDocument result = run_fit(parse_study(text, "study.json"), {});
  EXPECT_EQ(result.judgement.verdict, Verdict::kEquivalent);
  ASSERT_TRUE(result.band.shares && result.band.scatter && result.judgement.light);
  EXPECT_NEAR(std::hypot(result.fitted.surface.rms_height, result.band.shares->rest_rms), 250e-9,
              0.03 * 250e-9);
  // The RMS slope of the terms alone is below that of the whole mirror.
  const double whole = psd_moments(*layout.ground.psd).rms_slope_per_axis();
  EXPECT_LT(result.fitted.surface.rms_slope_per_axis, 0.8 * whole);
  EXPECT_NEAR(std::hypot(result.fitted.surface.rms_slope_per_axis, result.band.shares->rest_slope) / whole, 1,
              0.03);
  EXPECT_NE(text_of(page_of(result, true)).find("by wave optics"), std::string::npos);
}

TEST(BandChoice, WithoutTermsTheVerdictRestsOnDraws) {
  const std::string smooth = scene(2, 4000, "", 60);
  const ResultDocument result = run_fit(parse_study(smooth, "study.json"), {});
  ASSERT_TRUE(result.band.shares);
  EXPECT_EQ(result.band.shares->cut, 0);
  EXPECT_EQ(result.fitted.terms.size(), 0);
  EXPECT_EQ(result.judgement.verdict, Verdict::kEquivalent);
  ASSERT_GT(result.judgement.metrics.size(), 100u);
  int scattered = 0;
  for (const EquivalenceMetric& metric : result.judgement.metrics) {
    scattered += metric.standard_error > 0;
    EXPECT_TRUE(metric.degrees_of_freedom < 1e3 || metric.standard_error == 0) << metric.name;
  }
  EXPECT_GT(scattered, 100);
  // The verdict detects another roughness. Here the targets are those of a larger one.
  const std::string other = scene(
      0.8, 4000,
      R"(, "terms": {"band": "1 /m"}, "target": {"statistics": {"ee50": {"value": "2.2 um"}, "rms_height": {}}})",
      60);
  EXPECT_EQ(run_fit(parse_study(other, "study.json"), {}).judgement.verdict, Verdict::kDifferent);
}

// With balanced spherical aberration the peak of a ring passes the focus between two radii, while its ends
// stay as different as before. The flatter end determines the spread.
TEST(BandChoice, ARingIsHeldAtTheFlatterOfItsEndsWhereverItsPeakIs) {
  // With a given value, only the ring is judged.
  const auto asked = [](double ring) {
    return scene(3, 400,
                 fmt::format(R"(, "terms": {{"band": "auto"}}, "target": {{"statistics": {{"ring_fwhm": )"
                             R"({{"ring": "{} um", "value": "371 um"}}}}}})",
                             1e6 * ring));
  };
  const auto with_spherical = [&](double ring) {
    nlohmann::json text = nlohmann::json::parse(asked(ring));
    text["mirror"]["zernike"]["noll"] = {{"11", -32e-9}};  // a tenth of a wave of path
    return text.dump();
  };
  const Layout layout = layout_of(with_spherical(5.4e-6));
  const GeneralisedHarveyShack& mean = *layout.ground.mean_spot;
  const auto centred = [&](double ring) {
    const GeneralisedHarveyShack::RingPlanes planes = mean.ring_planes(ring);
    return planes.peak / (planes.upper - planes.lower);
  };
  double low = 4.6e-6, high = 6.4e-6;
  ASSERT_LT(centred(low) * centred(high), 0) << centred(low) << " " << centred(high);
  for (int k = 0; k < 12; ++k)
    (centred(0.5 * (low + high)) * centred(low) > 0 ? low : high) = 0.5 * (low + high);
  ASSERT_LT(std::abs(centred(low)), 0.005);
  const Layout at_peak = layout_of(with_spherical(low));
  const Study study = parse_study(with_spherical(low), "study.json");
  const GeneralisedHarveyShack::RingPlanes planes = mean.ring_planes(low);
  const double width = planes.upper - planes.lower, step = 0.01 * width;
  double flattest = HUGE_VAL, end = 0;
  for (const double plane : {planes.lower, planes.upper}) {
    const double slope =
        std::abs(mean.encircled_energy(low, plane + step) - mean.encircled_energy(low, plane - step)) /
        (2 * step);
    if (slope < flattest) flattest = slope, end = plane;
  }
  ASSERT_EQ(end, planes.lower) << "nothing tested: the upper end is the flatter one";
  const RealisationSpread spread({*at_peak.ground.psd, study.mirror, study.aperture, study.wavelength, mean},
                                 {{low, end}}, 2);
  const double moved = spread.light(at_peak.ground.shares->cut)[0] * std::sqrt(2.0) / (flattest * width);
  EXPECT_NEAR(at_peak.ground.shares->spread, moved / study.equivalence.margin,
              0.1 * moved / study.equivalence.margin);
}

}  // namespace aberfit
