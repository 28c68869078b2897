#pragma once
#include <cstdint>
#include <initializer_list>

namespace aberfit {

/// True if n >= 1 has no prime factor above `largest`, 5 or 7. Fourier transforms of such lengths are fast.
inline bool is_smooth(std::int64_t n, int largest = 7) {
  for (const int prime : {2, 3, 5, 7})
    while (prime <= largest && n % prime == 0) n /= prime;
  return n == 1;
}

/// The largest smooth number up to n, and the smallest from n >= 1 on.
inline std::int64_t smooth_up_to(std::int64_t n) {
  while (n > 1 && !is_smooth(n)) --n;
  return n;
}
inline std::int64_t smooth_from(std::int64_t n) {
  while (!is_smooth(n)) ++n;
  return n;
}

}  // namespace aberfit
