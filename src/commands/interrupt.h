#pragma once
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace aberfit::internal {

/// While it lives, the first SIGINT or SIGTERM only asks to come to an end; one that comes a second later or
/// more ends the process.
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

/// The end that a command line sets to a run, counted from when it was made.
class TimeLimit {
 public:
  /// A time with its unit, "60 s", "5 min" or "2 h"; empty: no limit. Throws InputError for what is none, and
  /// for one that is not positive.
  explicit TimeLimit(const std::string& text);

  bool over() const;
  bool is_set() const { return limit_.count() > 0; }
  std::chrono::steady_clock::time_point end() const;
  /// For the reader: "--time-limit 60 s".
  std::string text() const { return "--time-limit " + text_; }

 private:
  std::string text_;
  std::chrono::duration<double> limit_{0};  // 0: none
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// Ends the process when the time limit of the command line is over, as a signal would: for commands that
/// have nothing to keep before they are done. Says so on standard error; exit code 4.
class HardLimit {
 public:
  /// As TimeLimit takes it.
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
