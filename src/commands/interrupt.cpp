#include "interrupt.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <utility>

#include "aberfit/commands/program.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"

namespace aberfit::internal {
namespace {

// A signal handler may write only to such variables, and one process has one set of signals.
std::atomic<bool> asked_to_end{false};
std::atomic<std::int64_t> asked_at{0};  // [ns], of the monotonic clock
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free);

// The first signal asks for the best so far, a second one ends the process. `timeout` and batch systems send
// the same signal to the process and to its group, so signals within a second count as one.
void ask_to_end(int signal) {
  constexpr std::int64_t kOneWish = 1'000'000'000;
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const std::int64_t at = std::int64_t(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
  if (!asked_to_end) {
    asked_at = at;
    asked_to_end = true;
  } else if (at - asked_at > kOneWish) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

}  // namespace

// Signals that the caller ignores (nohup, a shell's background jobs) stay ignored.
Interrupt::Interrupt() {
  asked_to_end = false;
  for (const auto& [signal, before] : {std::pair{SIGINT, &before_int_}, {SIGTERM, &before_term_}}) {
    *before = std::signal(signal, ask_to_end);
    if (*before == SIG_IGN) std::signal(signal, SIG_IGN);
  }
}

Interrupt::~Interrupt() {
  std::signal(SIGINT, before_int_);
  std::signal(SIGTERM, before_term_);
}

bool Interrupt::asked() const { return asked_to_end; }

TimeLimit::TimeLimit(const std::string& text) : text_(text) {
  if (text.empty()) return;
  try {
    limit_ = std::chrono::duration<double>(parse_quantity(text, Dimension::kTime));
  } catch (const UnitError&) {  // reported below
  }
  if (!(limit_.count() > 0))
    throw InputError("command line", "", "--time-limit \"" + text + "\"",
                     "a positive time with its unit (s, min, h), e.g. \"60 s\"");
}

bool TimeLimit::over() const { return is_set() && std::chrono::steady_clock::now() >= end(); }

std::chrono::steady_clock::time_point TimeLimit::end() const {
  constexpr std::chrono::hours kLongest(24 * 365 * 100);  // within the range of the clock
  return begin_ + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                      std::min<std::chrono::duration<double>>(limit_, kLongest));
}

HardLimit::HardLimit(const std::string& text) : limit_(text) {
  if (!limit_.is_set()) return;
  watch_ = std::thread([this] {
    std::unique_lock lock(mutex_);
    if (done_.wait_until(lock, limit_.end(), [this] { return is_done_; })) return;
    fmt::print(stderr, "aberfit: stopped by {}; nothing is written\n", limit_.text());
    std::_Exit(int(ExitCode::kInterrupted));
  });
}

HardLimit::~HardLimit() {
  if (!watch_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    is_done_ = true;
  }
  done_.notify_one();
  watch_.join();
}

}  // namespace aberfit::internal
