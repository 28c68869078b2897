#include "aberfit/core/memory.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>

namespace aberfit {
namespace {

TEST(AlignedMemory, LiesOnCacheLinesAndLargeOneOnHugePages) {
  for (const std::size_t bytes : {std::size_t(0), std::size_t(1), std::size_t(100), std::size_t(4 << 20) - 1,
                                  std::size_t(4 << 20), std::size_t(9'000'001)}) {
    void* const memory = aligned_memory(bytes);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(memory) % (bytes < (4 << 20) ? 64 : 1 << 21), 0u) << bytes;
    std::memset(memory, 7, bytes);
    std::free(memory);
  }
}

TEST(AlignedMemory, ThatIsNotToBeHadIsBadAlloc) {
  const std::size_t all = std::numeric_limits<std::size_t>::max();
  EXPECT_THROW(aligned_memory(all), std::bad_alloc);
  EXPECT_THROW(aligned_memory(all - 5'000'000), std::bad_alloc);
}

}  // namespace
}  // namespace aberfit
