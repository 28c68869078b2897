#include "aberfit/core/content_hash.h"

#include <fmt/format.h>

#include <cstdint>

namespace aberfit {

// The prime is 2^88 + 0x13b: modulo 2^128 a product is a shift and a small product, of two halves of 64 bits.
std::string content_hash(std::string_view bytes) {
  constexpr std::uint64_t kSmall = 0x13b, kMask = 0xffffffff;
  std::uint64_t high = 0x6c62272e07bb0142, low = 0x62b821756295c58d;
  for (const char c : bytes) {
    low ^= static_cast<unsigned char>(c);
    const std::uint64_t lower = (low & kMask) * kSmall, upper = (low >> 32) * kSmall + (lower >> 32);
    high = high * kSmall + (upper >> 32) + (low << 24);
    low = (upper << 32) | (lower & kMask);
  }
  return fmt::format("{:016x}{:016x}", high, low);
}

}  // namespace aberfit
