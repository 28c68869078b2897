#include "aberfit/core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>

namespace aberfit {
namespace {

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

}  // namespace
}  // namespace aberfit
