#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

#include "aberfit/core/parallel.h"

namespace aberfit::internal {

/// Memory of `sum_chunks`, which calls reuse.
struct PartialSums {
  std::vector<double> total;
  std::vector<std::vector<double>> partial;
};

/// sums->total = sum over chunks 0 .. count-1 of the vector of `size` that add_chunk(chunk, double* sum) adds
/// to zero. Each chunk has its own vector and these are added in order, so threads change no bit.
template <typename AddChunk>
void sum_chunks(std::size_t count, std::size_t size, int threads, const AddChunk& add_chunk,
                PartialSums* sums) {
  constexpr std::size_t kWave = 128;  // number of partial vectors held, which limits memory
  sums->total.assign(size, 0.0);
  if (sums->partial.size() < std::min(count, kWave)) sums->partial.resize(std::min(count, kWave));
  for (std::size_t wave = 0; wave < count; wave += kWave) {
    const std::size_t in_wave = std::min(kWave, count - wave);
    parallel_for(in_wave, threads, [&](std::size_t i) {
      sums->partial[i].assign(size, 0.0);
      add_chunk(wave + i, sums->partial[i].data());
    });
    for (std::size_t i = 0; i < in_wave; ++i)
      for (std::size_t j = 0; j < size; ++j) sums->total[j] += sums->partial[i][j];
  }
}

}  // namespace aberfit::internal
