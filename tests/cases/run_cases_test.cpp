// The loop over cases runs each once, for any threads, failures and earlier runs; and the gathered results.
#include "aberfit/cases/run_cases.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <map>
#include <set>
#include <thread>

#include "aberfit/cases/gather.h"
#include "aberfit/core/errors.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using test::ScratchFolder;

StudyCases study_with(const std::string& vary) {
  return {R"({ "aberfit": 1, "mirror": { "focal_length": "1 m" },
    "aperture": { "shape": "circle", "diameter": "0.2 m" }, "light": { "wavelength": "500 nm" },
    "roughness": { "psd": { "model": "uniform", "rms": "20 nm", "f_min": "10 /m", "f_max": "100 /m" } },
    "vary": )" +
              vary + "}",
          "s.json"};
}
const char* const kForty =
    R"({"over": {"/roughness/psd/rms": {"from": "1 nm", "to": "40 nm", "count": 40}}})";

class RunCases : public testing::Test {
 protected:
  explicit RunCases(const char* vary = kForty)
      : cases_(study_with(vary)), plan_(*cases_.study().vary, 1, "s.json") {}
  KnownCases known() const {
    std::size_t damaged = 0;
    return KnownCases(read_journals(folder_.file("cases"), &damaged));
  }
  CaseCounts run(const CaseWork& work, int threads = 3, const std::function<bool()>& interrupted = {}) {
    const KnownCases before = known();
    LocalQueue queue(cases_left(cases_, plan_, before, {}));
    CaseJournal journal(folder_.file("cases"));
    return run_cases(cases_, plan_, before, work, &queue, &journal, {threads, {}, interrupted});
  }
  static CaseOutcome height(const Study& study) {
    return {{{"height_m", std::get<UniformPsd>(*study.psd).rms}}, "", {}};
  }
  const ScratchFolder folder_;
  const StudyCases cases_;
  const CasePlan plan_;
};

TEST_F(RunCases, DoesEveryCaseOnceAndGathersThemInOrder) {
  const CaseCounts counts = run(height);
  EXPECT_EQ(counts.done, 40u);
  EXPECT_EQ(counts.failed, 0u);
  const SweepReport report = gather_cases(cases_, plan_, known());
  ASSERT_TRUE(report.is_complete());
  for (std::size_t k = 0; k < 40; ++k) {
    EXPECT_EQ(report.rows[k].index, k);
    EXPECT_NEAR(report.rows[k].values[0], 1e-9 * double(k + 1), 1e-20);
    EXPECT_EQ(report.rows[k].number[0], double(k + 1));
  }
  EXPECT_EQ(report.axes[0].unit, "nm");
  EXPECT_EQ(run(height).done, 0u) << "a second run has nothing to do";
}

TEST_F(RunCases, RecordsWhatFailsAndGoesOn) {
  const CaseCounts counts = run([](const Study& study) -> CaseOutcome {
    const double rms = std::get<UniformPsd>(*study.psd).rms;
    if (rms < 2.5e-9) throw FieldError("roughness.psd", "too smooth", "more");
    if (rms < 4.5e-9) throw ComputationError("no focus");
    return height(study);
  });
  EXPECT_EQ(counts.done, 36u);
  EXPECT_EQ(counts.failed, 4u);
  const SweepReport report = gather_cases(cases_, plan_, known());
  EXPECT_TRUE(report.is_complete());
  EXPECT_EQ(report.failed(), 4u);
  EXPECT_EQ(report.rows[0].error, "/roughness/psd: too smooth; allowed: more");
  EXPECT_EQ(report.rows[3].error, "no focus");
  EXPECT_TRUE(std::isnan(report.rows[0].values[0]));
  EXPECT_EQ(run(height).done, 0u) << "what failed is recorded, too";
}

TEST_F(RunCases, GoesOnWhereItWasInterrupted) {
  std::atomic<int> started = 0;
  const auto counts = run(
      [&](const Study& study) -> CaseOutcome {
        if (++started == 12) throw Interrupted("in the middle of a case");
        return height(study);
      },
      2, [&] { return started >= 12; });
  EXPECT_GE(counts.done, 10u);
  EXPECT_LE(counts.done, 12u);
  EXPECT_EQ(run(height).done, 40u - counts.done);
  EXPECT_TRUE(gather_cases(cases_, plan_, known()).is_complete());
}

// A folder may hold cases of an earlier study: equal ones are used, others left alone.
TEST_F(RunCases, TakesOverEqualCasesOfAnotherStudy) {
  run(height);
  const StudyCases more = study_with(
      R"({"over": {"/roughness/psd/rms": ["5 nm", "0.006 um", "50 nm"], "/light/wavelength": ["500 nm", "1 um"]}})");
  const CasePlan plan(*more.study().vary, 1, "s.json");
  const KnownCases before = known();
  LocalQueue queue(cases_left(more, plan, before, {}));
  CaseJournal journal(folder_.file("cases"));
  EXPECT_EQ(run_cases(more, plan, before, height, &queue, &journal, {1, {}, {}}).done, 4u);
  const SweepReport report = gather_cases(more, plan, known());
  ASSERT_TRUE(report.is_complete());
  EXPECT_NEAR(report.rows[2].values[0], 6e-9, 1e-20);
}

TEST_F(RunCases, DoesWhatIsTheSameTwiceOnce) {
  const StudyCases same =
      study_with(R"({"over": {"/roughness/psd/rms": ["20 nm", "0.02 um", "2e-8", 2e-8]}})");
  const CasePlan plan(*same.study().vary, 1, "s.json");
  LocalQueue queue(cases_left(same, plan, {}, {}));
  CaseJournal journal(folder_.file("cases"));
  const CaseCounts counts = run_cases(same, plan, {}, height, &queue, &journal, {2, {}, {}});
  EXPECT_EQ(counts.done, 1u);
  EXPECT_EQ(counts.failed, 1u);  // a number in quotes has no unit
  EXPECT_EQ(gather_cases(same, plan, known()).rows.size(), 4u);
}

TEST_F(RunCases, SayAPointerThatCannotBeMeant) {
  const auto check = [](const std::string& vary) {
    const StudyCases cases = study_with(vary);
    check_pointers(cases, CasePlan(*cases.study().vary, 1, "s.json"));
  };
  check(kForty);
  check(R"({"over": {"/roughness/psd/rms": ["-1 nm", "1 nm"]}})");  // one valid value is enough
  EXPECT_THROW(check(R"({"over": {"/roughness/psd/rns": ["1 nm", "2 nm"]}})"), InputError);
  EXPECT_THROW(check(R"({"over": {"/roughness/psd/rms": ["1 s", "2 s"]}})"), InputError);
  // Two values that depend on each other.
  check(R"({"over": {"/aperture/shape": ["annulus"], "/aperture/inner_diameter": ["0.1 m"]}})");
}

// Each case goes to one worker, in runs of neighbours.
TEST(LocalQueue, HandsOutEveryCaseOnce) {
  std::vector<std::size_t> left;
  for (std::size_t k = 0; k < 1000; ++k)
    if (k % 97 != 3) left.push_back(k);
  LocalQueue queue(left);
  std::mutex mutex;
  std::multiset<std::size_t> given;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {
        for (;;) {
          std::size_t first = 0, count = 0;
          if (t % 2) {
            queue.take(3, 32, &first, &count);
            EXPECT_LE(count, 32u);
          } else if (const auto one = queue.next()) {
            first = *one, count = 1;
          }
          if (count == 0) return;
          const std::lock_guard lock(mutex);
          for (std::size_t k = 0; k < count; ++k) given.insert(first + k);
        }
      });
  }
  EXPECT_EQ(given, std::multiset<std::size_t>(left.begin(), left.end()));
}

TEST(Progress, SaysRateAndTimeLeft) {
  EXPECT_EQ(progress_text(0, 2000, 0, 1), "0 of 2,000 cases");
  EXPECT_EQ(progress_text(1200, 2000, 3, 10), "1,200 of 2,000 cases, 120 per second, 7 s left, 3 failed");
  EXPECT_EQ(progress_text(10, 100, 0, 100), "10 of 100 cases, 10 s per case, 15 min left");
}

// A value failed once and is allowed now: the result has priority, in either order.
TEST(KnownCases, WhatWasDoneCountsBeforeWhatHadFailed) {
  CaseRecord failed, done;
  failed.id = "0", failed.base = done.base = "b", failed.error = "refused";
  failed.at = done.at = {{"/roughness/psd/rms", "\"1 nm\""}};
  done.id = "1";
  for (const auto& records : {std::vector{failed, done}, std::vector{done, failed}}) {
    const KnownCases known(records);
    ASSERT_NE(known.find("b", done.at), nullptr);
    EXPECT_EQ(known.find("b", done.at)->id, "1");
  }
}

}  // namespace
}  // namespace aberfit
