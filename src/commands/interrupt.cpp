#include "interrupt.h"

#include <atomic>
#include <csignal>
#include <utility>

namespace aberfit::internal {
namespace {

// What a signal handler may write to; all there is of it in the process.
std::atomic<bool> asked_to_end{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void ask_to_end(int signal) {
  asked_to_end = true;
  std::signal(signal, SIG_DFL);
}

}  // namespace

// What the caller ignores (nohup, a shell's background jobs) stays ignored.
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

}  // namespace aberfit::internal
