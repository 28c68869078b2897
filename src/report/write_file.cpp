#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "aberfit/core/errors.h"
#include "aberfit/report/result.h"

namespace aberfit {

void write_file(const std::string& path, const std::string& text) {
  namespace fs = std::filesystem;
  const auto fail = [&](const std::string& problem) {
    throw InputError(path, "", problem, "a file that can be written");
  };
  const fs::path target(path);
  std::error_code error;
  if (target.has_parent_path()) {
    fs::create_directories(target.parent_path(), error);
    if (error) fail("a folder that cannot be created (" + error.message() + ")");
  }
  // The file is beside the target, because a rename is only atomic within one file system. Process id and
  // count distinguish writers.
  static std::atomic<unsigned> count{0};
  fs::path aside = target;
  aside += ".part-" + std::to_string(::getpid()) + "-" + std::to_string(count++);
  const auto abandon = [&](const std::string& problem) {
    std::error_code ignored;
    fs::remove(aside, ignored);
    fail(problem);
  };

  errno = 0;
  std::ofstream out(aside, std::ios::binary | std::ios::trunc);
  if (!out) fail(std::string("a folder where no file can be created (") + std::strerror(errno) + ")");
  out.write(text.data(), std::streamsize(text.size()));
  out.close();
  if (!out) abandon(std::string("a failing write (") + std::strerror(errno) + ")");
  fs::rename(aside, target, error);
  if (error) abandon("an item that cannot be replaced (" + error.message() + ")");
}

}  // namespace aberfit
