#pragma once
#include <functional>
#include <string>

namespace aberfit {

/// Settings of a run that do not belong to its task.
struct RunContext {
  int threads = 1;
  std::function<void(const std::string&)> progress = {};  ///< receives progress lines; may be empty
  std::function<bool()> interrupted = {};                 ///< polled during the run; true: stop; may be empty

  bool stopped() const { return interrupted && interrupted(); }
  void say(const std::string& line) const {
    if (progress) progress(line);
  }
};

}  // namespace aberfit
