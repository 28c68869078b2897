#pragma once
#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

namespace aberfit::internal {

/// Counts the calls that run, so that the interpreter does not end below them: a thread that asks for its
/// lock then is killed, which C++ cannot survive.
class Running {
 public:
  Running() { ++count(); }
  ~Running() { --count(); }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  /// Asks all calls to stop and waits until they have; without the interpreter's lock.
  static void end_all() {
    ending() = true;
    while (count() > 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  static bool ends() { return ending(); }
  /// Sets the count to 0, in a process that was forked off: the calls go on in its parent only.
  static void forget() { count() = 0; }

 private:
  static std::atomic<int>& count() {
    static std::atomic<int> number{0};
    return number;
  }
  static std::atomic<bool>& ending() {
    static std::atomic<bool> is_ending{false};
    return is_ending;
  }
};

class Hooks;

/// Runs `work` on a thread without the interpreter's lock. Meanwhile this thread shows lines of progress and
/// watches for signals: Python delivers Ctrl-C only to the main thread while it holds the lock. After Ctrl-C,
/// or an exception of `progress`, the work is asked to stop. After Ctrl-C its result is returned if it is the
/// `best_so_far`; otherwise Ctrl-C goes on, so that it also ends a loop around many calls. Exceptions of the
/// work or of `progress` are thrown.
template <typename Result>
Result in_background(const std::function<Result(Hooks&)>& work, const pybind11::object& progress,
                     const std::function<bool(const Result&)>& best_so_far = {});

/// The hooks that `in_background` gives its work. Their members may be called from any thread.
class Hooks {
 public:
  void tell(const std::string& line) {
    const std::lock_guard lock(mutex_);
    line_ = line;
  }
  bool stopped() const { return stop_ || Running::ends(); }

 private:
  template <typename Result>
  friend Result in_background(const std::function<Result(Hooks&)>& work, const pybind11::object& progress,
                              const std::function<bool(const Result&)>& best_so_far);
  std::mutex mutex_;
  std::condition_variable ended_;
  bool done_ = false;
  std::atomic<bool> stop_{false};
  std::optional<std::string> line_;  // of progress, not yet shown
};

template <typename Result>
Result in_background(const std::function<Result(Hooks&)>& work, const pybind11::object& progress,
                     const std::function<bool(const Result&)>& best_so_far) {
  namespace py = pybind11;
  constexpr std::chrono::milliseconds kBetweenLooks{50};  // people do not notice it
  Hooks hooks;
  std::optional<Result> result;
  std::exception_ptr problem, of_progress;
  bool pressed = false;  // Ctrl-C
  const Running running;
  std::thread worker([&] {
    try {
      result.emplace(work(hooks));
    } catch (...) {
      problem = std::current_exception();
    }
    const std::lock_guard lock(hooks.mutex_);
    hooks.done_ = true;
    hooks.ended_.notify_one();
  });
  {
    const py::gil_scoped_release release;
    std::unique_lock lock(hooks.mutex_);
    while (!hooks.ended_.wait_for(lock, kBetweenLooks, [&] { return hooks.done_; })) {
      const std::optional<std::string> line = std::exchange(hooks.line_, std::nullopt);
      lock.unlock();
      {
        const py::gil_scoped_acquire acquire;
        try {
          if (PyErr_CheckSignals() != 0) throw py::error_already_set();
          if (line && !progress.is_none() && !hooks.stop_) progress(*line);
        } catch (py::error_already_set& error) {
          hooks.stop_ = true;
          pressed = error.matches(PyExc_KeyboardInterrupt);
          if (!pressed) of_progress = std::current_exception();
        }
      }
      lock.lock();
    }
    lock.unlock();
    worker.join();
  }
  if (of_progress) std::rethrow_exception(of_progress);
  if (problem) std::rethrow_exception(problem);
  if (pressed && !(best_so_far && best_so_far(*result))) {
    PyErr_SetNone(PyExc_KeyboardInterrupt);
    throw py::error_already_set();
  }
  return std::move(*result);
}

}  // namespace aberfit::internal
