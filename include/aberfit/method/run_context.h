#pragma once
#include <functional>
#include <string>

namespace aberfit {

/// What a run works with besides its task.
struct RunContext {
  int threads = 1;
  std::function<void(const std::string&)> progress = {};  ///< takes a line now and then; may be empty
  std::function<bool()> interrupted = {};  ///< asked now and then; true: come to an end; may be empty

  bool stopped() const { return interrupted && interrupted(); }
  void say(const std::string& line) const {
    if (progress) progress(line);
  }
};

}  // namespace aberfit
