#pragma once
#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "aberfit/commands/program.h"
#include "aberfit/commands/run_options.h"
#include "aberfit/report/page.h"

namespace aberfit::internal {

/// Shows progress on standard error. On a terminal it rewrites one line and clears it before anything else is
/// printed. In a log, or on a terminal without escape sequences (TERM=dumb), it prints a line now and then if
/// the work takes long.
class ProgressLine {
 public:
  explicit ProgressLine(bool wanted);
  ~ProgressLine() { clear(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  bool shown() const { return shown_; }
  void show(const std::string& line);
  void clear();

 private:
  bool shown_, rewrites_;
  bool dirty_ = false;
  std::chrono::steady_clock::time_point logged_ = std::chrono::steady_clock::now();
};

/// The options of the command line, with progress on `progress`, which must outlive them.
RunOptions run_options(const CommandLine& line, ProgressLine* progress);

/// Prints the document if the command line asks for JSON, otherwise the page. The document is made only if
/// asked for, because its provenance reads every input file.
void print(const CommandLine& line, const std::function<nlohmann::ordered_json()>& document,
           const Page& page);

/// Says in which folder the results are, unless the command line asks for quiet.
void say_where(const CommandLine& line);

}  // namespace aberfit::internal
