#include "aberfit/core/content_hash.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>

namespace aberfit {
namespace {

constexpr std::size_t kBlock = 64;  // [bytes]

// The first 64 primes; their roots give the constants of FIPS 180-4.
constexpr std::array<int, 64> kPrimes = [] {
  std::array<int, 64> primes{};
  std::size_t count = 0;
  for (int n = 2; count < primes.size(); ++n)
    if (std::all_of(primes.begin(), primes.begin() + std::ptrdiff_t(count),
                    [n](int p) { return n % p != 0; }))
      primes[count++] = n;
  return primes;
}();

// The first 32 bits of the fraction of a root.
std::uint32_t fraction_bits(long double root) {
  return std::uint32_t((root - std::floor(root)) * 4294967296.0L);
}

struct Sha256 {
  std::array<std::uint32_t, 8> state;
  std::array<std::uint32_t, 64> constant;

  Sha256() {
    for (std::size_t i = 0; i < state.size(); ++i)
      state[i] = fraction_bits(std::sqrt((long double)kPrimes[i]));
    for (std::size_t i = 0; i < constant.size(); ++i)
      constant[i] = fraction_bits(std::cbrt((long double)kPrimes[i]));
  }
  void take(const unsigned char* block) {
    std::array<std::uint32_t, 64> w;
    for (std::size_t i = 0; i < 16; ++i)
      w[i] = std::uint32_t(block[4 * i]) << 24 | std::uint32_t(block[4 * i + 1]) << 16 |
             std::uint32_t(block[4 * i + 2]) << 8 | std::uint32_t(block[4 * i + 3]);
    for (std::size_t i = 16; i < w.size(); ++i) {
      const std::uint32_t a = w[i - 15], b = w[i - 2];
      w[i] = w[i - 16] + (std::rotr(a, 7) ^ std::rotr(a, 18) ^ a >> 3) + w[i - 7] +
             (std::rotr(b, 17) ^ std::rotr(b, 19) ^ b >> 10);
    }
    std::array<std::uint32_t, 8> s = state;
    for (std::size_t i = 0; i < w.size(); ++i) {
      const std::uint32_t first = s[7] + (std::rotr(s[4], 6) ^ std::rotr(s[4], 11) ^ std::rotr(s[4], 25)) +
                                  ((s[4] & s[5]) ^ (~s[4] & s[6])) + constant[i] + w[i];
      const std::uint32_t second = (std::rotr(s[0], 2) ^ std::rotr(s[0], 13) ^ std::rotr(s[0], 22)) +
                                   ((s[0] & s[1]) ^ (s[0] & s[2]) ^ (s[1] & s[2]));
      s = {first + second, s[0], s[1], s[2], s[3] + first, s[4], s[5], s[6]};
    }
    for (std::size_t i = 0; i < state.size(); ++i) state[i] += s[i];
  }
};

}  // namespace

std::string content_hash(std::string_view bytes) {
  static const Sha256 begin;
  Sha256 hash = begin;
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  const std::size_t whole = bytes.size() / kBlock * kBlock;
  for (std::size_t at = 0; at < whole; at += kBlock) hash.take(data + at);
  // A 1 bit, zeros, and the length in bits fill the last block or the last two.
  std::array<unsigned char, 2 * kBlock> end{};
  const std::size_t left = bytes.size() - whole, size = left + 9 <= kBlock ? kBlock : 2 * kBlock;
  std::copy_n(data + whole, left, end.begin());
  end[left] = 0x80;
  for (std::size_t i = 0; i < 8; ++i)
    end[size - 1 - i] = (unsigned char)(std::uint64_t(bytes.size()) * 8 >> (8 * i));
  for (std::size_t at = 0; at < size; at += kBlock) hash.take(end.data() + at);
  std::string text;
  for (const std::uint32_t word : hash.state) text += fmt::format("{:08x}", word);
  return text;
}

}  // namespace aberfit
