#include "aberfit/core/parallel.h"

#include <omp.h>

#include <algorithm>
#include <exception>

namespace aberfit {

void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  const int team = int(std::min<std::size_t>(std::size_t(std::max(threads, 1)), count));
  if (team <= 1) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  std::exception_ptr failure;  // an exception must not leave a parallel region
#pragma omp parallel for schedule(dynamic) num_threads(team)
  for (std::size_t i = 0; i < count; ++i) {
    try {
      body(i);
    } catch (...) {
#pragma omp critical(aberfit_parallel_for)
      if (!failure) failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

int available_threads() { return std::max(1, omp_get_num_procs()); }

}  // namespace aberfit
