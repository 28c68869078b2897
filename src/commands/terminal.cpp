#include "terminal.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "aberfit/commands/terminal_text.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "array_files.h"
#include "output_directory.h"

namespace aberfit::internal {
namespace {

constexpr std::chrono::seconds kBetweenLines{20};

}  // namespace

ProgressLine::ProgressLine(bool wanted) : shown_(wanted), rewrites_(takes_escapes(stderr)) {}

void ProgressLine::show(const std::string& line) {
  if (!rewrites_) {
    const auto now = std::chrono::steady_clock::now();
    if (now - logged_ < kBetweenLines) return;
    logged_ = now;
    fmt::print(stderr, "{}\n", line);
  } else {
    fmt::print(stderr, "\r\x1b[K{}", line);
    dirty_ = true;
  }
  std::fflush(stderr);
}

void ProgressLine::clear() {
  if (dirty_) fmt::print(stderr, "\r\x1b[K");
  dirty_ = false;
}

RunOptions run_options(const CommandLine& line, ProgressLine* progress) {
  RunOptions options;
  options.threads = line.threads;
  if (!line.pictures.empty()) options.pictures = picture_format(line.pictures);
  options.output_directory = line.output_directory;
  options.force = line.force;
  options.command_line = line.typed;
  if (!line.quiet)
    options.tell = [progress](const std::string& text) {
      progress->clear();
      fmt::print(stderr, "{}\n", text);
    };
  if (!line.arrays.empty()) options.arrays = array_format(line.arrays);
  options.coefficients_file = line.coefficients_file;
  options.chart_seconds = line.chart_seconds;
  if (progress->shown()) options.progress = [progress](const std::string& text) { progress->show(text); };
  return options;
}

void print(const CommandLine& line, const std::function<nlohmann::ordered_json()>& document,
           const Page& page) {
  TextStyle style;
  if (isatty(STDOUT_FILENO) == 1) style = {std::size_t(text_width()), takes_colour(stdout)};
  std::string text = line.json ? document().dump(2) : text_of(page, style);
  if (!text.empty() && text.back() != '\n') text += '\n';
  // We flush before anything goes to standard error, which may be the same file. A full disk is an error.
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
    throw InputError("standard output", "", fmt::format("a failing write ({})", std::strerror(errno)),
                     "a file or device that can be written to");
}

void say_where(const CommandLine& line) {
  if (!line.quiet) fmt::print(stderr, "results in {}\n", line.output_directory);
}

}  // namespace aberfit::internal
