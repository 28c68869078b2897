#include "aberfit/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace aberfit {
namespace {

// A nested call runs its loop alone, because the outer one already uses all requested threads.
thread_local bool in_team = false;

class InTeam {
 public:
  InTeam() { in_team = true; }
  ~InTeam() { in_team = false; }
};

}  // namespace

// Each call starts its threads and joins them: tens of microseconds, against bodies of milliseconds, and no
// thread spins. An OpenMP team does spin (libgomp, unless OMP_WAIT_POLICY is set before the program starts),
// which costs ten times the work on a busy machine.
void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  const std::size_t team = in_team ? 1 : std::min(std::size_t(std::max(threads, 1)), count);
  if (team <= 1) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  std::atomic<std::size_t> next = 0;
  std::exception_ptr failure;  // an exception must not leave a thread
  std::size_t failed = count;  // index of the first body that threw
  std::mutex failure_mutex;
  const auto work = [&] {
    const InTeam mark;
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        body(i);
      } catch (...) {
        const std::lock_guard lock(failure_mutex);
        if (i < failed) failed = i, failure = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> others;
    others.reserve(team - 1);
    try {
      while (others.size() < team - 1) others.emplace_back(work);
    } catch (const std::system_error&) {
      // The system has no more threads; the existing ones do the work.
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

int available_threads() { return std::max(1, int(std::thread::hardware_concurrency())); }

}  // namespace aberfit
