#include "aberfit/core/random.h"

#include <Random123/philox.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "normal_kernel.h"

namespace aberfit {
namespace {

// FNV-1a gives streams of different names different keys.
std::uint64_t name_hash(std::string_view name) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  return hash;
}

r123::Philox4x64::ctr_type block(const std::array<std::uint64_t, 2>& key, std::uint64_t index) {
  return r123::Philox4x64()({{index, 0, 0, 0}}, {{key[0], key[1]}});
}

// The 53 bits give centres of intervals, so the value is never 0 or 1.
double open_unit(std::uint64_t bits) { return (double(bits >> 11) + 0.5) * 0x1p-53; }

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::string_view name) : key_{seed, name_hash(name)} {}

std::array<double, 2> RandomStream::uniform_pair(std::uint64_t index) const {
  const auto bits = block(key_, index);
  return {open_unit(bits[0]), open_unit(bits[1])};
}

std::array<double, 2> RandomStream::normal_pair(std::uint64_t index) const {
  const auto [u, v] = uniform_pair(index);
  const double radius = std::sqrt(-2.0 * std::log(u)), angle = 2.0 * std::numbers::pi * v;
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

void RandomStream::normal_pairs(std::uint64_t first, int count, double* one, double* other) const {
  constexpr int kBlock = 256;
  alignas(64) double u[kBlock], v[kBlock];
  for (int at = 0; at < count; at += kBlock) {
    const int size = std::min(kBlock, count - at);
    for (int i = 0; i < size; ++i) {
      const auto pair = uniform_pair(first + std::uint64_t(at + i));
      u[i] = pair[0];
      v[i] = pair[1];
    }
    std::fill(u + size, u + kBlock, 0.5);
    std::fill(v + size, v + kBlock, 0.5);
    internal::box_muller(best_instruction_set(), (size + 7) / 8 * 8, u, v);
    std::copy_n(u, size, one + at);
    std::copy_n(v, size, other + at);
  }
}

std::uint64_t RandomStream::bits(std::uint64_t index) const { return block(key_, index)[0]; }

}  // namespace aberfit
