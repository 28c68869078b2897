#include "aberfit/report/result_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <set>

#include "aberfit/core/errors.h"
#include "aberfit/report/result.h"

namespace aberfit {
namespace {

namespace fs = std::filesystem;

// The names of what a run has written, one a line, so that the next one knows what is not the user's.
constexpr const char* kManifest = ".aberfit-files";

std::set<std::string> files_below(const fs::path& folder) {
  std::set<std::string> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    if (!entry.is_directory() || entry.is_symlink())
      files.insert(entry.path().lexically_relative(folder).generic_string());
  return files;
}

// Names that lead out of the folder are not what a run wrote.
std::set<std::string> files_of_last_run(const fs::path& folder) {
  std::set<std::string> files = {kManifest};
  std::ifstream in(folder / kManifest);
  for (std::string line; std::getline(in, line);) {
    const fs::path name = fs::path(line).lexically_normal();
    if (!name.empty() && name.is_relative() && *name.begin() != "..") files.insert(name.generic_string());
  }
  return files;
}

// Whether nothing but plain files of one file system is there, in no folders but those that the last run
// made: then the folder can be made anew.
bool can_be_made_anew(const fs::path& folder) {
  std::set<std::string> folders;
  for (const std::string& file : files_of_last_run(folder))
    if (const fs::path name(file); name.has_parent_path()) folders.insert(name.begin()->string());
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const bool plain = entry.is_regular_file() && !entry.is_symlink();
    const bool ours =
        entry.is_directory() && !entry.is_symlink() && folders.contains(entry.path().filename().string());
    if (!plain && !ours) return false;
  }
  return true;
}

// What no run wrote is in both places until the exchange: killed at any moment, nothing is lost.
void keep_files_of_user(const fs::path& from, const fs::path& to) {
  const std::set<std::string> runs = files_of_last_run(from);
  for (const std::string& file : files_below(from)) {
    if (runs.contains(file) || fs::exists(fs::symlink_status(to / file))) continue;
    fs::create_directories((to / file).parent_path());
    fs::create_hard_link(from / file, to / file);
  }
  fs::permissions(to, fs::status(from).permissions());
}

bool exchange(const fs::path& a, const fs::path& b) {
  return ::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0;
}

// Where folders cannot change places (a mount point, the working folder of a shell, a folder that holds more
// than results): file by file, and without a result.json as long as they are of two runs.
void replace_files(const fs::path& from, const fs::path& to) {
  constexpr const char* kResult = "result.json";
  fs::remove(to / kResult);
  for (const std::string& file : files_of_last_run(to)) fs::remove(to / file);
  for (const std::string& file : files_below(from)) {
    if (file == kResult) continue;
    fs::create_directories((to / file).parent_path());
    fs::rename(from / file, to / file);
  }
  if (fs::exists(from / kResult)) fs::rename(from / kResult, to / kResult);
}

bool holds_working_folder(const fs::path& folder) {
  const fs::path relative = fs::current_path().lexically_relative(folder);
  return !relative.empty() && *relative.begin() != "..";
}

[[noreturn]] void refuse(const std::string& folder, const std::string& found) {
  throw InputError(folder, "", found, "a folder to write to");
}

}  // namespace

ResultFolder::ResultFolder(const std::string& folder) : named_(folder) {
  if (folder.empty()) return;
  try {
    folder_ = fs::weakly_canonical(fs::absolute(folder)).lexically_normal();
    if (!folder_.has_filename()) folder_ = folder_.parent_path();
    if (fs::exists(folder_) && !fs::is_directory(folder_)) refuse(named_, "a file of that name");
    for (fs::path p = folder_.parent_path(); p.has_relative_path() && !fs::exists(p); p = p.parent_path())
      made_ = p;
    fs::create_directories(folder_.parent_path());
    fs::path beside = folder_.parent_path() / ("." + folder_.filename().string());
    if (::access(folder_.parent_path().c_str(), W_OK) != 0 || holds_working_folder(folder_))
      beside = folder_ / ".aberfit";
    part_ = beside, part_ += ".part";
    lock_ = beside, lock_ += ".lock";
    lock();
    fs::remove_all(part_);  // of a run that was killed
    fs::create_directory(part_);
    write_file((part_ / kManifest).string(), "");
  } catch (const fs::filesystem_error& error) {
    leave();
    refuse(named_, fmt::format("a folder that cannot be written to ({})", error.code().message()));
  } catch (const InputError& error) {
    leave();
    throw InputError(named_, "", error.found(), error.allowed());
  }
}

ResultFolder::~ResultFolder() { leave(); }

// A lock that ends with the process, however that ends. The file may have been removed by its last holder
// between opening and locking it: then once more.
void ResultFolder::lock() {
  for (;;) {
    lock_fd_ = ::open(lock_.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
    if (lock_fd_ < 0)
      refuse(named_, fmt::format("a folder that cannot be written to ({})", std::strerror(errno)));
    if (::flock(lock_fd_, LOCK_EX | LOCK_NB) != 0) {
      if (errno != EWOULDBLOCK) return;  // a file system without locks
      ::close(lock_fd_);
      lock_fd_ = -1;
      throw InputError(named_, "", "another run that writes its results there",
                       "one run at a time: wait for it, or name another folder with --output");
    }
    struct stat held, named;
    if (::fstat(lock_fd_, &held) == 0 && ::stat(lock_.c_str(), &named) == 0 && held.st_ino == named.st_ino)
      return;
    ::close(lock_fd_);
  }
}

void ResultFolder::show() {
  if (!wanted()) return;
  try {
    std::string manifest;
    for (const std::string& file : files_below(part_)) manifest += file + "\n";
    write_file((part_ / kManifest).string(), manifest);
    const bool inside = part_.parent_path() == folder_;
    if (!fs::exists(folder_)) {
      fs::rename(part_, folder_);
    } else if (inside || !can_be_made_anew(folder_)) {
      replace_files(part_, folder_);
    } else {
      keep_files_of_user(folder_, part_);
      if (!exchange(part_, folder_)) replace_files(part_, folder_);
    }
    shown_ = true;
  } catch (const fs::filesystem_error& error) {
    const std::string kept = part_.string();
    part_.clear();
    refuse(named_, fmt::format("results that cannot be put there ({}); they are in {}",
                               error.code().message(), kept));
  }
}

void ResultFolder::leave() {
  std::error_code ignored;
  if (lock_fd_ < 0) part_.clear();  // another run's
  if (!part_.empty()) fs::remove_all(part_, ignored);
  if (lock_fd_ >= 0) {
    fs::remove(lock_, ignored);
    ::close(lock_fd_);
    lock_fd_ = -1;
  }
  if (shown_ || made_.empty()) return;
  for (fs::path p = folder_.parent_path(); fs::remove(p, ignored) && p != made_;) p = p.parent_path();
}

}  // namespace aberfit
