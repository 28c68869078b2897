#pragma once
#include <functional>
#include <string>

#include "aberfit/core/errors.h"

namespace aberfit {

/// Settings of a run that do not belong to its task.
struct RunContext {
  int threads = 1;
  std::function<void(const std::string&)> progress = {};  ///< receives progress lines; may be empty
  std::function<bool()> interrupted = {};                 ///< polled during the run; true: stop; may be empty

  bool stopped() const { return interrupted && interrupted(); }
  /// Throws Interrupted if the run is to stop; for work without a partial result.
  void stop_if_asked() const {
    if (stopped()) throw Interrupted("stopped before there was a result");
  }
  void say(const std::string& line) const {
    if (progress) progress(line);
  }
};

}  // namespace aberfit
