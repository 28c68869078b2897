#include "aberfit/method/term_search.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "aberfit/commands/run.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/method/ray_count.h"
#include "aberfit/report/check_report.h"
#include "aberfit/study/read_study.h"
#include "reference_scenes.h"
#include "short_form.h"
#include "study/study_texts.h"

namespace aberfit {
namespace {

// As every order of a study would come out, and what the search asked for.
struct Trials {
  std::set<int> passing;
  double near_from = 0;  // orders from here on are promising
  std::vector<int> screened, confirmed;
  TermTrials hooks() {
    TermTrials trials;
    const auto point = [](const TermsSpec& asked) {
      FrontierPoint p;
      const int order = asked.zernike ? *asked.zernike->n_max : asked.fourier->count;
      p.order = order;
      p.terms = asked.zernike ? (order + 1) * (order + 2) / 2 - 3 : 2 * order;
      return p;
    };
    trials.screen = [this, point](const TermsSpec& asked) {
      FrontierPoint p = point(asked);
      screened.push_back(p.order);
      p.screened = true;
      p.fitted_mismatch = p.order >= near_from ? 1 : 100;
      return p;
    };
    trials.confirm = [this, point](const TermsSpec& asked) {
      FrontierPoint p = point(asked);
      confirmed.push_back(p.order);
      p.passes = passing.contains(p.order);
      p.fitted_mismatch = p.passes ? 0.5 : 2;
      p.held_out_mismatch = 0.02 + 0.001 * std::abs(p.order - 20);
      return p;
    };
    return trials;
  }
};

Trials passing_from(int lowest) {
  Trials trials;
  for (int order = lowest; order <= 100; ++order) trials.passing.insert(order);
  return trials;
}

// The same, but sets that fail are as far off as `mismatch` says of their order.
template <typename F>
TermTrials failing_by(TermTrials trials, F mismatch) {
  trials.confirm = [confirm = trials.confirm, mismatch](const TermsSpec& asked) {
    FrontierPoint p = confirm(asked);
    if (!p.passes) p.fitted_mismatch = mismatch(p.order);
    return p;
  };
  return trials;
}

Frontier search(const OrderRange& range, const TermTrials& trials) {
  return search_terms(CovarianceKind::kFull, 0.01, range, trials);
}

int chosen(const Frontier& frontier) {
  int order = 0, count = 0;
  for (const FrontierPoint& point : frontier.points)
    if (point.chosen) order = point.order, ++count;
  EXPECT_EQ(count, 1);
  return order;
}

TEST(NextOrder, StepsOneUpTo14AndNoMoreThan9PercentBeyond) {
  for (int n = 2; n < 14; ++n) EXPECT_EQ(next_order(n), n + 1);
  for (int n = 14; n < 100; ++n) {
    EXPECT_GT(next_order(n), n);
    EXPECT_LE(next_order(n), std::max(n + 1.0, 1.09 * n));
  }
}

TEST(TermSearch, FindsTheLowestOrderThatPassesWhereTheClimbSteppedOverIt) {
  // 43 -> 46: 44 and 45 lie between.
  ASSERT_EQ(next_order(43), 46);
  Trials trials{{44, 46, 49}, 30, {}, {}};
  const Frontier frontier = search({10, 60, false}, trials.hooks());
  EXPECT_EQ(chosen(frontier), 44);
  EXPECT_TRUE(std::is_sorted(frontier.points.begin(), frontier.points.end(),
                             [](const auto& a, const auto& b) { return a.terms < b.terms; }));
  for (const int order : trials.confirmed) EXPECT_GE(order, 30) << "confirmed without need";
}

TEST(TermSearch, GoesOnWherePassingIsNotMonotone) {
  Trials trials{{12, 15}, 2, {}, {}};
  EXPECT_EQ(chosen(search({10, 60, false}, trials.hooks())), 12);
  Trials later{{15}, 2, {}, {}};
  EXPECT_EQ(chosen(search({10, 60, false}, later.hooks())), 15);
}

TEST(TermSearch, TakesTheNearestSetWhereNonePasses) {
  Trials trials{{}, 15, {}, {}};
  const Frontier frontier = search({10, 30, false}, trials.hooks());
  EXPECT_EQ(chosen(frontier), 20);
  EXPECT_NE(frontier.message.find("no set"), std::string::npos);
  Trials hopeless{{}, 1000, {}, {}};
  TermTrials hooks = hopeless.hooks();
  hooks.screen = [screen = hooks.screen](const TermsSpec& asked) {
    FrontierPoint p = screen(asked);
    p.fitted_mismatch = 40 + std::abs(p.order - 13);
    return p;
  };
  const Frontier far = search({10, 30, false}, hooks);
  EXPECT_EQ(chosen(far), 13);  // of short fits, too
  EXPECT_TRUE(hopeless.confirmed.empty());
}

// Without short fits: by strides. A set that fails stays threefold away for every order that it lacks.
TermTrials without_screen(Trials* trials) {
  TermTrials hooks = trials->hooks();
  hooks.screen = nullptr;
  return failing_by(hooks, [trials](int order) {
    const auto next = trials->passing.lower_bound(order);
    return next == trials->passing.end() ? HUGE_VAL : std::pow(3, *next - order);
  });
}

TEST(TermSearch, StridesUpWhereShortFitsSayNothing) {
  Trials trials = passing_from(23);
  EXPECT_EQ(chosen(search({10, 40, false}, without_screen(&trials))), 23);
  EXPECT_TRUE(trials.screened.empty());
  EXPECT_LE(trials.confirmed.size(), 9u);
  // What was stepped over is looked at.
  Trials slow = passing_from(12);
  const TermTrials overshoot = failing_by(without_screen(&slow), [](int) { return 1e9; });
  EXPECT_EQ(chosen(search({10, 40, false}, overshoot)), 12);
  // One failure does not end the way down, two in a row do.
  Trials gap = passing_from(23);
  gap.passing.insert(21);
  EXPECT_EQ(chosen(search({23, 40, false}, without_screen(&gap))), 21);
  Trials below = passing_from(2);
  EXPECT_EQ(chosen(search({10, 40, false}, without_screen(&below))), 2);
}

// A search one order after the other has no end that can be foretold: 55 fits for 33 orders down, as many up
// where each set is nearly good enough.
TEST(TermSearch, TakesStridesThatGrowBothWays) {
  Trials below = passing_from(27);
  EXPECT_EQ(chosen(search({60, 80, false}, without_screen(&below))), 27);
  EXPECT_LE(below.confirmed.size(), 14u);
  Trials above = passing_from(93);
  const TermTrials nearly = failing_by(without_screen(&above), [](int) { return 1.05; });
  EXPECT_EQ(chosen(search({40, 80, false}, nearly)), 93);
  EXPECT_LE(above.confirmed.size(), 15u);
}

TermTrials on_cells(Eigen::Index cells, TermTrials trials) {
  trials.cells = [cells](const TermsSpec&) { return cells; };
  return trials;
}

constexpr Eigen::Index kVeryMany = 100000, kHuge = 150000;

// On large grids each set costs a fit of ten seconds and its verdict, on the way to a twentieth fewer terms.
TEST(TermSearch, FindsOrdersOnLargeGridsToNineAndToTwentyPercent) {
  for (const Eigen::Index cells : {Eigen::Index(0), kManyCells - 1, kManyCells, kVeryMany - 1, kVeryMany})
    for (const int lowest : {22, 30, 47, 80}) {
      Trials trials = passing_from(lowest);
      const TermTrials far = failing_by(without_screen(&trials), [](int) { return 1e4; });
      const int found = chosen(search({20, 90, false}, on_cells(cells, far)));
      const bool exact = cells < kManyCells || (cells < kVeryMany && lowest <= 23);
      EXPECT_GE(found, lowest);
      EXPECT_LE(found, (exact ? 1 : cells < kVeryMany ? 1.1 : 1.25) * lowest);
      const std::set<int> confirmed(trials.confirmed.begin(), trials.confirmed.end());
      EXPECT_EQ(confirmed.contains(found - 1) && confirmed.contains(found - 2), exact)
          << found << " of " << lowest << " on " << cells;
    }
}

// Ten seconds and more a set: from a quarter of the way through what is expected, to 20 %, and never far
// below.
TEST(TermSearch, TakesAThirdFewerSetsOnVeryManyCells) {
  std::size_t few = 0, many = 0;
  for (const int lowest : {8, 12, 14, 18, 25, 33}) {
    Trials closely = passing_from(lowest), coarsely = passing_from(lowest);
    const OrderRange expected{8, 40, false};
    const Frontier close = search(expected, on_cells(kManyCells - 1, without_screen(&closely)));
    EXPECT_EQ(chosen(close), lowest);
    EXPECT_EQ(close.message.find("so many cells"), std::string::npos) << close.message;
    const Frontier coarse = search(expected, on_cells(kVeryMany, without_screen(&coarsely)));
    const int found = chosen(coarse);
    EXPECT_TRUE(coarse.message.ends_with("; on so many cells to within 20 % of the order")) << coarse.message;
    EXPECT_GE(found, lowest);
    EXPECT_LE(found, std::max(1.25 * lowest, lowest + 1.0));
    EXPECT_EQ(coarsely.confirmed.front(), 16);
    few += closely.confirmed.size();
    many += coarsely.confirmed.size();
  }
  EXPECT_LE(many, 2.0 / 3 * double(few)) << many << " of " << few;
  // Where sets below what is expected pass, the lowest of it is as good.
  Trials below = passing_from(2);
  EXPECT_LE(chosen(search({8, 40, false}, on_cells(kVeryMany, without_screen(&below)))), 9);
  // No set within a fifth of one that failed, which would not be told from it.
  Trials nearly = passing_from(40);
  const TermTrials by_little = failing_by(without_screen(&nearly), [](int) { return 1.05; });
  EXPECT_LE(chosen(search({8, 40, false}, on_cells(kVeryMany, by_little))), 50);
  EXPECT_GE(nearly.confirmed[1], 19);
}

// A minute and more a set: what passes is taken, unless twice the order of one that fails.
TEST(TermSearch, TakesTheFirstThatPassesOnHugeGrids) {
  for (const int lowest : {2, 12, 16}) {
    Trials trials = passing_from(lowest);
    const Frontier found = search({9, 40, false}, on_cells(kHuge, without_screen(&trials)));
    EXPECT_EQ(chosen(found), 16);
    EXPECT_EQ(trials.confirmed, std::vector<int>{16});
    EXPECT_TRUE(found.message.ends_with("; on so many cells to within 50 % of the order")) << found.message;
  }
  Trials fewer = passing_from(12);
  EXPECT_EQ(chosen(search({9, 40, false}, on_cells(kHuge - 1, without_screen(&fewer)))), 12);
  // Up from one that fails not in steps of half.
  Trials above = passing_from(18);
  const TermTrials nearly = failing_by(without_screen(&above), [](int) { return 1.05; });
  EXPECT_EQ(chosen(search({8, 40, false}, on_cells(kHuge, nearly))), 19);
  EXPECT_EQ(above.confirmed, (std::vector<int>{16, 19}));
  // More than twice what is taken to fail: one in between.
  for (const auto& [lowest, takes] : {std::pair{10, 14}, {18, 21}}) {
    Trials wide = passing_from(lowest);
    EXPECT_EQ(chosen(search({8, 60, false}, on_cells(kHuge, without_screen(&wide)))), takes);
    EXPECT_EQ(wide.confirmed.front(), 21);
    EXPECT_EQ(wide.confirmed.size(), 2u);
  }
}

// Like a deep spot (g 14): 20, 18, ... tolerances at n = 15, 16, ..., a tenth less an order. By twos and
// fours the way to 45 takes seven sets.
TEST(TermSearch, TakesTheNextStrideFromThePaceOfTheLastTwo) {
  Trials trials = passing_from(45);
  const TermTrials slow =
      failing_by(without_screen(&trials), [](int order) { return std::exp(0.1 * (45 - order)); });
  EXPECT_EQ(chosen(search({15, 60, false}, slow)), 45);
  const auto first =
      std::find_if(trials.confirmed.begin(), trials.confirmed.end(), [](int order) { return order >= 45; });
  EXPECT_LE(first - trials.confirmed.begin(), 4) << "sets that fail on the way up";
  // As before where they rise.
  Trials rising = passing_from(30);
  const TermTrials worse = failing_by(without_screen(&rising), [](int order) { return 1 + 0.01 * order; });
  EXPECT_EQ(chosen(search({15, 60, false}, worse)), 30);
}

// A pace of a hundredth an order asks for all 65 orders at once, from two sets that may have been lucky.
TEST(TermSearch, TakesAtMostHalfTheOrderAtOnce) {
  Trials trials = passing_from(80);
  const TermTrials slow =
      failing_by(without_screen(&trials), [](int order) { return std::exp(0.01 * (80 - order)); });
  EXPECT_EQ(chosen(search({15, 80, false}, slow)), 80);
  double most = 0;
  for (std::size_t k = 1; k < trials.confirmed.size(); ++k)
    most = std::max(most, double(trials.confirmed[k]) / trials.confirmed[k - 1]);
  EXPECT_LE(most, 1.5);
  EXPECT_GT(most, 1.4) << "nothing tested: the pace asks for less";
}

TEST(TermSearch, GoesUpFirstWhereTheExpectedOrderFails) {
  Trials trials = passing_from(46);
  EXPECT_EQ(chosen(search({10, 40, false}, without_screen(&trials))), 46);
  Trials none;
  const Frontier frontier = search({10, 40, false}, without_screen(&none));
  EXPECT_NE(frontier.message.find("no set"), std::string::npos);
  EXPECT_LE(none.confirmed.back(), 53);  // a third beyond the range
}

TEST(TermSearch, DoublesPlaneWavesWhereZernikesNeedOrdersAbove100) {
  Trials trials;
  for (int count = 300; count < 20000; ++count) trials.passing.insert(count);
  const TermTrials hooks = failing_by(trials.hooks(), [](int order) { return 300.0 / order; });
  const Frontier frontier = search({10, 100, true}, hooks);
  const int found = chosen(frontier);
  EXPECT_GE(found, 300);
  EXPECT_LE(found, 1.2 * 300);
  EXPECT_TRUE(trials.screened.empty());
  EXPECT_NE(frontier.message.find("plane waves"), std::string::npos);
}

// 32, 64, 128 and 256 waves, then 181: on many cells that is near enough to 150, on very many 256 is; on
// fewer 152 is next.
TEST(TermSearch, EndsAmongPlaneWavesSoonerOnManyCells) {
  struct Expected {
    Eigen::Index cells;
    int chosen;
    std::vector<int> confirmed;
  };
  for (const Expected& expected :
       {Expected{kManyCells - 1, 152, {32, 64, 128, 256, 181, 152}},
        Expected{kManyCells, 181, {32, 64, 128, 256, 181}}, Expected{kVeryMany, 256, {64, 128, 256}}}) {
    Trials trials;
    for (int count = 150; count < 20000; ++count) trials.passing.insert(count);
    const TermTrials hooks = failing_by(trials.hooks(), [](int order) { return 300.0 / order; });
    EXPECT_EQ(chosen(search({10, 100, true}, on_cells(expected.cells, hooks))), expected.chosen);
    EXPECT_EQ(trials.confirmed, expected.confirmed);
  }
  Trials all;
  for (int count = 2; count < 20000; ++count) all.passing.insert(count);
  const Frontier frontier = search({10, 100, true}, on_cells(kVeryMany, all.hooks()));
  EXPECT_EQ(chosen(frontier), 64);
  EXPECT_NE(frontier.message.find("within a factor 2 of their number"), std::string::npos)
      << frontier.message;
}

// 32, 64, 128 and 256 waves; where the one that passes takes the most rays - an annulus's are a few less -
// that is near enough to 150.
TEST(TermSearch, EndsAmongPlaneWavesSoonerOnTheMostRays) {
  for (const Eigen::Index rays : {kMostAutomaticRays / 2, kMostAutomaticRays - 256}) {
    const bool most = rays > kMostAutomaticRays / 2;
    Trials trials;
    for (int count = 150; count < 20000; ++count) trials.passing.insert(count);
    TermTrials hooks = failing_by(trials.hooks(), [](int order) { return 300.0 / order; });
    // What a set that fails has taken says nothing of the ones that pass.
    hooks.confirm = [rays, confirm = hooks.confirm](const TermsSpec& asked) {
      FrontierPoint point = confirm(asked);
      point.rays = point.passes ? rays : kMostAutomaticRays;
      return point;
    };
    const Frontier frontier = search({10, 100, true}, hooks);
    EXPECT_EQ(chosen(frontier), most ? 256 : 152);
    EXPECT_EQ(trials.confirmed,
              most ? std::vector<int>({32, 64, 128, 256}) : std::vector<int>({32, 64, 128, 256, 181, 152}));
    EXPECT_EQ(
        frontier.message.find("on so many rays to within a factor 2 of their number") != std::string::npos,
        most)
        << frontier.message;
  }
}

// A spot that no number of waves mends was followed up to 16,384 of them, hours.
TEST(TermSearch, StopsDoublingPlaneWavesWhereMoreBringNothing) {
  Trials none;  // all of them 2 tolerances off
  const Frontier frontier = search({10, 100, true}, none.hooks());
  EXPECT_NE(frontier.message.find("no set"), std::string::npos);
  EXPECT_EQ(none.confirmed.back(), 128);
  // One doubling in vain does not end it.
  Trials late;
  for (int count = 250; count < 20000; ++count) late.passing.insert(count);
  const TermTrials hooks = failing_by(late.hooks(), [](int order) {
    return order == 64 ? 9 : order == 32 ? 8 : 3;
  });
  EXPECT_LE(chosen(search({10, 100, true}, hooks)), 300);
}

// Sets that have nearly met their tolerances differ by their draws; the next may meet them.
TEST(TermSearch, DoublesPlaneWavesOnWhereTheyHaveNearlyMetTheirTolerances) {
  Trials trials;
  for (int count = 250; count < 20000; ++count) trials.passing.insert(count);
  const auto off = [](double distance) {
    return [distance](int order) { return order == 32 ? 1.2 : distance; };
  };
  const int found = chosen(search({10, 100, true}, failing_by(trials.hooks(), off(1.9))));
  EXPECT_GE(found, 250);
  EXPECT_LE(found, 300);
  Trials farther = trials;
  farther.confirmed.clear();
  const Frontier frontier = search({10, 100, true}, failing_by(farther.hooks(), off(2.1)));
  EXPECT_NE(frontier.message.find("no set"), std::string::npos);
}

// Roughness from half a cycle across is mostly tilt, and sets without it end at 4 tolerances.
TEST(TermSearch, TiltIsAmongTheTermsWhereItMatters) {
  const auto study = [](double f_min, double exponent) {
    return parse_study(
        fmt::format(
            R"({{"aberfit": 1, "mirror": {{"focal_length": "7 m"}}, "aperture": {{"shape": "circle", )"
            R"("diameter": "2 m"}}, "light": {{"wavelength": "632.8 nm"}}, "roughness": {{"psd": {{"model": )"
            R"("power-law", "rms": "18 nm", "exponent": {}, "f_min": "{} /m", "f_max": "6.4 /m"}}}}}})",
            exponent, f_min),
        "study.json");
  };
  const auto first = [](const Study& of) { return expected_orders(lay_groundwork(of)).first; };
  EXPECT_EQ(first(study(0.26, 3.5)), 1);
  EXPECT_EQ(first(study(0.5, 3)), 1);  // one cycle, tilt 7.2 % of the variance
  EXPECT_EQ(first(study(0.5, 2)), 2);  // 3 %
  EXPECT_EQ(first(study(1, 3)), 2);    // 0.7 %
  const ResultDocument result = run_fit(study(0.26, 3.5), {});
  EXPECT_EQ(result.verdict, Verdict::kEquivalent);
  ASSERT_FALSE(result.terms.zernike.empty());
  EXPECT_EQ(result.terms.zernike.front().n, 1);
  EXPECT_NE(result.frontier->message.find("tilt"), std::string::npos) << result.frontier->message;
  EXPECT_EQ(resolved(study(0.26, 3.5), result)["terms"]["zernike"]["n_min"], 1);
  EXPECT_GT(result.surface.captured_fraction, 0.9);
  EXPECT_LE(result.surface.captured_fraction, 1 + 1e-9);
}

// A deep spot of 11 modes across, on a grid of a hundred thousand cells and more: begun and left at once.
TEST(TermSearch, FitsKnowHowManyCellsTheyBeginOn) {
  const Study study = parse_study(
      R"({"aberfit": 1, "mirror": {"focal_length": "14 m"}, "aperture": {"shape": "circle", "diameter": "1 m"}, )"
      R"("light": {"wavelength": "632.8 nm"}, "roughness": {"psd": {"model": "gaussian", "rms": "0.58 um", )"
      R"("correlation_length": "60 mm"}}, "terms": {"band": "all"}})",
      "study.json");
  const Groundwork ground = lay_groundwork(study);
  const OrderRange expected = expected_orders(ground);
  const int first = expected.low + (expected.high - expected.low) / 4;
  ASSERT_GT(first, expected.low);
  bool begun = false;
  RunOptions how;
  how.progress = [&](const std::string& line) { begun = begun || line.starts_with("fit"); };
  how.interrupted = [&] { return begun; };
  const ResultDocument result = run_fit(study, how);
  EXPECT_EQ(result.fit.status, FitStatus::kCancelled);
  ASSERT_FALSE(result.terms.zernike.empty());
  EXPECT_EQ(result.terms.zernike.back().n, first);
  EXPECT_GE(result.rays, kVeryMany);
  const Eigen::Index predicted = first_cells(study, ground, result.terms, make_targets(study, ground, 1));
  EXPECT_NEAR(double(predicted), double(result.rays), 0.03 * double(result.rays));
}

// Long: only with `ctest -C statistics -L statistics`.
TEST(FullStatistics, TermSearchEndsAtTheFewestOfAnExhaustiveSearch) {
  const Study asked = parse_study(small_study("\"auto\"", "8192"), "study.json");
  ASSERT_TRUE(asked.terms.automatic());
  const ResultDocument found = run_fit(asked, {});
  ASSERT_TRUE(found.frontier.has_value());
  EXPECT_EQ(found.verdict, Verdict::kEquivalent);
  EXPECT_EQ(found.fit.status, FitStatus::kConverged);
  EXPECT_GE(found.rays, kRaysPerTerm * found.terms.size());
  Eigen::Index fewest = 0;
  for (int n = 2; fewest == 0 && n <= found.terms.zernike.back().n; ++n) {
    Study given = asked;
    given.terms = zernikes_up_to(n, CovarianceKind::kFull);
    const ResultDocument result = run_fit(given, {});
    double worst = 0;
    for (Eigen::Index k = 0; k < result.fit.smooth_statistics.size(); ++k)
      worst = std::max(
          worst, std::abs(result.fit.smooth_statistics[k] - aim_of(result.targets[std::size_t(k)]).value) /
                     aim_of(result.targets[std::size_t(k)]).tolerance);
    if (worst <= 1 && result.fit.status == FitStatus::kConverged && result.verdict == Verdict::kEquivalent)
      fewest = result.terms.size();
  }
  ASSERT_GT(fewest, 0);
  EXPECT_LE(double(found.terms.size()), 1.2 * double(fewest));
}

// What passed where a search looked a second time has to pass there again: the resolved study of an annulus
// went on from its draw instead, to another surface.
TEST_WITH_SHORT_FORM(TermSearch, ResolvesToAStudyThatGivesTheSameFit) {
  bool looked_twice = false;
  const std::vector<std::string> texts{annulus_study().dump(), small_study("\"auto\"", "\"auto\"")};
  for (const std::string& text : aberfit::test::all_or_few(whole, texts, {0})) {
    const Study asked = parse_study(text, "study.json");
    const ResultDocument found = run_fit(asked, {});
    const nlohmann::ordered_json written = resolved(asked, found);
    EXPECT_TRUE(written["terms"]["zernike"]["n_max"].is_number_integer());
    EXPECT_TRUE(written["trace"]["rays"].is_number_integer());
    looked_twice = looked_twice || written["fit"]["second_look"];
    const Study again = parse_study(written.dump(), "study.json");
    EXPECT_FALSE(again.terms.automatic());
    const ResultDocument same = run_fit(again, {});
    EXPECT_EQ(same.rays, found.rays);
    EXPECT_FALSE(same.frontier.has_value());
    EXPECT_EQ(same.fit.coefficients, found.fit.coefficients);  // to the last bit
    EXPECT_EQ(same.verdict, found.verdict);
  }
  EXPECT_TRUE(looked_twice);  // one of them at least is a case
}

TEST(TermSearch, DoesNotDependOnTheThreadCount) {
  const Study asked = parse_study(small_study("\"auto\"", "\"auto\""), "study.json");
  RunOptions one, two;
  one.threads = 1;
  two.threads = 2;
  EXPECT_EQ(run_fit(asked, one).fit.coefficients, run_fit(asked, two).fit.coefficients);
}

TEST(BandUse, SharesOfAUniformBandAreDifferencesOfPowers) {
  const Study study = parse_study(small_study(R"({"zernike": {"n_max": 10}})", "65536"), "study.json");
  const Groundwork ground = lay_groundwork(study);
  double captured = 0;
  const TermSet terms = make_terms(study, ground, study.terms, &captured);
  const BandUse band = band_use(study, ground, terms, 65536);
  const double cut = 11 / (2 * std::numbers::pi * 0.2), low = 2.5, high = 12;
  // int f df and int f^3 df.
  const double height = (high * high - cut * cut) / (high * high - low * low);
  const double slope = (std::pow(high, 4) - std::pow(cut, 4)) / (std::pow(high, 4) - std::pow(low, 4));
  constexpr double kRounding = 1e-12;
  EXPECT_NEAR(band.modelled_f_max, cut, kRounding * cut);
  EXPECT_EQ(band.limited_by, "zernike");
  EXPECT_NEAR(band.left_out_height_share, height, kRounding);
  EXPECT_NEAR(band.left_out_slope_share, slope, kRounding);
  EXPECT_NEAR(band.ee90_change, std::sqrt(1 - slope) - 1, kRounding);
  // Spacing 1/40 m: rays see up to 20 /m, all of it; at 1/10 m up to 5 /m.
  EXPECT_EQ(band_use(study, ground, terms, 100).limited_by, "zernike");
  EXPECT_EQ(band_use(study, ground, terms, 10).limited_by, "rays");
  EXPECT_NEAR(band_use(study, ground, terms, 10).modelled_f_max,
              0.5 * std::sqrt(10 / (std::numbers::pi * 0.04)), kRounding * 10);
}

}  // namespace
}  // namespace aberfit
