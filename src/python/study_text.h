#pragma once
#include <string>
#include <vector>

#include "aberfit/study/read_study.h"

namespace aberfit::internal {

/// A study that is read when a command runs, so that reading, too, is done without the interpreter's lock.
struct StudyText {
  std::string text, path;  // text empty: the file at path
  std::vector<std::string> changes;
  StudyData data;

  Study read() const {
    return text.empty() ? read_study(path, changes, data) : parse_study(text, path, changes, data);
  }
};

}  // namespace aberfit::internal
