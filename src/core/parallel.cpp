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

// A body that is itself in a team works alone: the team already has the threads that were asked for.
thread_local bool in_team = false;

class InTeam {
 public:
  InTeam() { in_team = true; }
  ~InTeam() { in_team = false; }
};

}  // namespace

// Threads are started per call and joined at its end: tens of microseconds beside bodies of milliseconds, and
// nobody spins while waiting. An OpenMP team does (libgomp, unless OMP_WAIT_POLICY says otherwise before the
// program starts), which on a busy machine costs ten times the work.
void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  const std::size_t team = in_team ? 1 : std::min(std::size_t(std::max(threads, 1)), count);
  if (team <= 1) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  std::atomic<std::size_t> next = 0;
  std::exception_ptr failure;  // an exception must not leave a thread
  std::size_t failed = count;  // the first body of those that threw
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
      // The system gives no more threads: those there are do the work.
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

int available_threads() { return std::max(1, int(std::thread::hardware_concurrency())); }

}  // namespace aberfit
