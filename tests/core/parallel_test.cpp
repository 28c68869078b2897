// Every index runs once, for any number of threads, depth of nesting and exception.
#include "aberfit/core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace aberfit {
namespace {

using Counts = std::vector<std::atomic<int>>;

bool all_are(const Counts& counts, int wanted) {
  for (const std::atomic<int>& count : counts)
    if (count != wanted) return false;
  return true;
}

// Two bodies that wait for each other, so that two threads must take them. False after five seconds.
class Meeting {
 public:
  bool both_are_here() {
    ++here_;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    while (here_ < 2 && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    return here_ >= 2;
  }

 private:
  std::atomic<int> here_ = 0;
};

TEST(ParallelFor, RunsEveryIndexOnce) {
  for (const int threads : {-1, 0, 1, 2, 3, 16})
    for (const std::size_t count : {std::size_t(0), std::size_t(1), std::size_t(2), std::size_t(1000)}) {
      Counts counts(count);
      parallel_for(count, threads, [&](std::size_t i) { ++counts.at(i); });
      EXPECT_TRUE(all_are(counts, 1)) << count << " on " << threads;
    }
}

TEST(ParallelFor, TakesAsManyThreadsAsItMay) {
  Meeting meeting;
  std::atomic<int> met = 0;
  parallel_for(2, 2, [&](std::size_t) { met += meeting.both_are_here(); });
  EXPECT_EQ(met, 2);
}

// The outer call has the threads, so an inner call runs alone, in order.
TEST(ParallelFor, NestedRunsEveryIndexOnceOnTheThreadOfItsBody) {
  constexpr std::size_t kOuter = 7, kInner = 50;
  for (const int threads : {1, 2, 4}) {
    Counts counts(kOuter * kInner);
    std::atomic<int> strangers = 0;
    parallel_for(kOuter, threads, [&](std::size_t i) {
      const std::thread::id own = std::this_thread::get_id();
      parallel_for(kInner, threads, [&](std::size_t j) {
        ++counts.at(i * kInner + j);
        strangers += threads > 1 && std::this_thread::get_id() != own;
      });
    });
    EXPECT_TRUE(all_are(counts, 1)) << threads;
    EXPECT_EQ(strangers, 0) << threads;
  }
}

TEST(ParallelFor, AnExceptionReachesTheCallerFromAnyThread) {
  for (const bool from_caller : {true, false}) {
    const std::thread::id caller = std::this_thread::get_id();
    Meeting meeting;
    std::string caught;
    try {
      parallel_for(2, 2, [&](std::size_t) {
        if (!meeting.both_are_here()) return;
        if ((std::this_thread::get_id() == caller) == from_caller) throw std::runtime_error("of a body");
      });
    } catch (const std::runtime_error& error) {
      caught = error.what();
    }
    EXPECT_EQ(caught, "of a body") << from_caller;
  }
}

TEST(ParallelFor, ThrowsWhatTheFirstBodyThrowsWhateverTheThreads) {
  for (const int threads : {1, 2, 7}) {
    std::atomic<int> calls = 0;
    try {
      parallel_for(100, threads, [&](std::size_t i) {
        ++calls;
        if (i % 10 == 3) throw std::runtime_error(std::to_string(i));
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "3");
    }
    EXPECT_GE(calls, 4);
  }
}

TEST(ParallelFor, TheOtherItemsOfATeamStillEnd) {
  Counts counts(100);
  EXPECT_THROW(parallel_for(100, 3,
                            [&](std::size_t i) {
                              ++counts.at(i);
                              if (i % 10 == 4) throw std::runtime_error("one of ten");
                            }),
               std::runtime_error);
  EXPECT_TRUE(all_are(counts, 1));
}

TEST(ParallelFor, AnExceptionOfANestedBodyReachesTheOutermostCaller) {
  Counts counts(4);
  EXPECT_THROW(parallel_for(4, 2,
                            [&](std::size_t i) {
                              ++counts.at(i);
                              parallel_for(3, 2, [&](std::size_t j) {
                                if (i == 2 && j == 1) throw std::runtime_error("inside");
                              });
                            }),
               std::runtime_error);
  EXPECT_TRUE(all_are(counts, 1));
  // The caller has left the team, so its next call has two threads.
  Meeting meeting;
  std::atomic<int> met = 0;
  parallel_for(2, 2, [&](std::size_t) { met += meeting.both_are_here(); });
  EXPECT_EQ(met, 2);
}

}  // namespace
}  // namespace aberfit
