#include "interrupt.h"

#include <atomic>
#include <csignal>

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

Interrupt::Interrupt() {
  asked_to_end = false;
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, ask_to_end);
}

Interrupt::~Interrupt() {
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);
}

bool Interrupt::asked() const { return asked_to_end; }

}  // namespace aberfit::internal
