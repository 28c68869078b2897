#pragma once
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "aberfit/core/errors.h"

namespace aberfit::test {

/// A folder of this process for files that readers need, in memory if the machine has such a place.
class FuzzFolder {
 public:
  FuzzFolder() {
    std::error_code error;
    const std::filesystem::path memory = "/dev/shm";
    const std::filesystem::path base =
        access(memory.c_str(), W_OK) == 0 ? memory : std::filesystem::temp_directory_path(error);
    folder_ = base / ("aberfit_fuzz_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  ~FuzzFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  FuzzFolder(const FuzzFolder&) = delete;
  FuzzFolder& operator=(const FuzzFolder&) = delete;

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  /// Writes the bytes; returns the path.
  std::string write(const std::string& name, std::string_view bytes) const {
    std::ofstream(path(name), std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
    return path(name);
  }

 private:
  std::filesystem::path folder_;
};

/// The folder of this process.
inline const FuzzFolder& fuzz_folder() {
  static const FuzzFolder folder;
  return folder;
}

inline std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("no file " + path.string());
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void require(bool holds, const std::string& promise) {
  if (!holds) throw std::logic_error("does not hold: " + promise);
}

/// Requires that an error says place, found and allowed.
inline void require_whole(const InputError& error) {
  require(!error.file().empty() && !error.found().empty() && !error.allowed().empty(),
          std::string("an error names file, found and allowed: ") + error.what());
}

/// Calls `read`, which may throw an InputError. Returns whether it did not.
template <class Read>
bool read_or_refuse(const Read& read) {
  try {
    read();
    return true;
  } catch (const InputError& error) {
    require_whole(error);
    return false;
  }
}

}  // namespace aberfit::test
