#pragma once
#include <pybind11/pybind11.h>

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace aberfit::internal {

/// What the work of `in_background` is given. Its members may be called from any thread.
class Hooks {
 public:
  void tell(const std::string& line) {
    const std::lock_guard lock(mutex_);
    line_ = line;
  }
  bool stopped() const { return stop_; }

 private:
  template <typename Result>
  friend Result in_background(const std::function<Result(Hooks&)>& work, const pybind11::object& progress);
  std::mutex mutex_;
  std::condition_variable ended_;
  bool done_ = false;
  std::atomic<bool> stop_{false};
  std::optional<std::string> line_;  // of progress, not yet shown
};

/// Runs `work` on a thread without the interpreter's lock. Meanwhile this thread shows lines of progress and
/// watches for signals: Python delivers Ctrl-C only to the main thread while it holds the lock. After Ctrl-C,
/// or an exception of `progress`, the work is asked to stop. Its result is returned if it has one after
/// Ctrl-C; otherwise its exception, or that of `progress`, is thrown.
template <typename Result>
Result in_background(const std::function<Result(Hooks&)>& work, const pybind11::object& progress) {
  namespace py = pybind11;
  constexpr std::chrono::milliseconds kBetweenLooks{50};
  Hooks hooks;
  std::optional<Result> result;
  std::exception_ptr problem, of_progress;
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
          if (!error.matches(PyExc_KeyboardInterrupt)) of_progress = std::current_exception();
        }
      }
      lock.lock();
    }
    lock.unlock();
    worker.join();
  }
  if (of_progress) std::rethrow_exception(of_progress);
  if (problem) std::rethrow_exception(problem);
  return std::move(*result);
}

}  // namespace aberfit::internal
