#pragma once
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace aberfit::internal {

/// While it lives, the first SIGINT or SIGTERM only asks the work to end. Another at least a second later
/// ends the process.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  bool asked() const;

 private:
  void (*before_int_)(int);
  void (*before_term_)(int);
};

/// The time limit that the command line sets for a run, counted from construction.
class TimeLimit {
 public:
  /// text: a time with its unit, "60 s", "5 min" or "2 h"; empty: no limit. Throws InputError unless it is a
  /// positive time.
  explicit TimeLimit(const std::string& text);

  bool over() const;
  bool is_set() const { return limit_.count() > 0; }
  std::chrono::steady_clock::time_point end() const;
  /// The option in messages: "--time-limit 60 s".
  std::string text() const { return "--time-limit " + text_; }

 private:
  std::string text_;
  std::chrono::duration<double> limit_{0};  // 0: none
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// Ends the process like a signal when the time limit of the command line is over, with a message on standard
/// error and exit code 4. It serves commands that have no partial result to keep.
class HardLimit {
 public:
  /// text: as for TimeLimit.
  explicit HardLimit(const std::string& text);
  ~HardLimit();
  HardLimit(const HardLimit&) = delete;
  HardLimit& operator=(const HardLimit&) = delete;

 private:
  TimeLimit limit_;
  std::mutex mutex_;
  std::condition_variable done_;
  bool is_done_ = false;
  std::thread watch_;
};

}  // namespace aberfit::internal
