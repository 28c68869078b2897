#include "aberfit/cases/journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string_view>
#include <thread>
#include <unordered_map>

#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"

namespace aberfit {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kBetweenSyncs{1};
constexpr int kMostWorkers = 9999;

[[noreturn]] void refuse_journal(const std::string& path) {
  throw InputError(path, "", fmt::format("a failing write ({})", std::strerror(errno)),
                   "a folder with permission to write and free space");
}

void make_folder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw InputError(folder, "", fmt::format("a folder that cannot be created ({})", error.message()),
                     "a folder with permission to write and free space");
}

// The lock ends with its process. On a file system without locks every process gets one.
bool lock_file(int fd) { return ::flock(fd, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK; }
bool has_locks(int fd) { return ::flock(fd, LOCK_EX | LOCK_NB) == 0 || errno == EWOULDBLOCK; }

int open_file(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (fd < 0) refuse_journal(path);
  return fd;
}

// Length of the complete lines.
off_t length_of_lines(int fd) {
  off_t end = ::lseek(fd, 0, SEEK_END);
  char part[4096];
  while (end > 0) {
    const off_t begin = std::max<off_t>(0, end - off_t(sizeof part));
    const ssize_t read = ::pread(fd, part, std::size_t(end - begin), begin);
    if (read <= 0) return end;
    for (ssize_t k = read; k-- > 0;)
      if (part[k] == '\n') return begin + k + 1;
    end = begin;
  }
  return 0;
}

std::string name_of_machine() {
  char name[256] = "";
  ::gethostname(name, sizeof name - 1);
  return name;
}

}  // namespace

CaseJournal::CaseJournal(std::string folder) : folder_(std::move(folder)) {}

CaseJournal::~CaseJournal() {
  if (fd_ < 0) return;
  ::fsync(fd_);
  ::close(fd_);
}

void CaseJournal::open() {
  make_folder(folder_);
  for (int k = 1; fd_ < 0; ++k) {
    if (k > kMostWorkers) throw InputError(folder_, "", "too many workers", fmt::format("{}", kMostWorkers));
    path_ = fmt::format("{}/worker-{:04}.jsonl", folder_, k);
    const int fd = open_file(path_);
    if (!has_locks(fd)) {
      ::close(fd);
      path_ = fmt::format("{}/worker-{}-{}.jsonl", folder_, name_of_machine(), ::getpid());
      fd_ = open_file(path_);
    } else if (lock_file(fd)) {
      fd_ = fd;
    } else {
      ::close(fd);
    }
  }
  if (::ftruncate(fd_, length_of_lines(fd_)) != 0) refuse_journal(path_);
  // The name of a new file is on the disk only when its folder is.
  const int folder = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) ::fsync(folder), ::close(folder);
}

void CaseJournal::add(const CaseRecord& record) {
  const std::string line = to_line(record);
  const std::lock_guard lock(mutex_);
  if (fd_ < 0) open();
  const ssize_t written = ::write(fd_, line.data(), line.size());
  if (written != ssize_t(line.size())) {
    if (written >= 0) errno = ENOSPC;
    const int why = errno;
    if (::ftruncate(fd_, length_of_lines(fd_)) == 0) ::fsync(fd_);
    errno = why;
    refuse_journal(path_);
  }
  dirty_ = true;
  if (std::chrono::steady_clock::now() - synced_ < kBetweenSyncs) return;
  if (::fsync(fd_) != 0) refuse_journal(path_);
  dirty_ = false;
  synced_ = std::chrono::steady_clock::now();
}

void CaseJournal::sync() {
  const std::lock_guard lock(mutex_);
  if (dirty_ && ::fsync(fd_) != 0) refuse_journal(path_);
  dirty_ = false;
}

std::vector<CaseRecord> read_journals(const std::string& folder, std::size_t* damaged) {
  std::vector<std::string> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".jsonl") files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  std::vector<CaseRecord> records;
  std::unordered_map<std::string, std::size_t> place_of;
  *damaged = 0;
  for (const std::string& file : files) {
    const std::string text = file_bytes(file).value_or("");
    for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
      std::optional<CaseRecord> record = record_of(text.substr(begin, end - begin));
      if (!record) {
        ++*damaged;
        continue;
      }
      const auto [at, is_new] = place_of.emplace(record->id, records.size());
      if (is_new)
        records.push_back(std::move(*record));
      else if (!records[at->second].error.empty() && record->error.empty())
        records[at->second] = std::move(*record);
    }
  }
  return records;
}

std::string foreign_journal(const std::string& folder) {
  const std::string begin_of_record = R"({"id":)";
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("worker-") || !name.ends_with(".jsonl")) continue;
    const std::string text = file_bytes(entry.path().string()).value_or("");
    const std::string_view same = std::string_view(text).substr(0, begin_of_record.size());
    bool known = begin_of_record.starts_with(same);
    for (std::size_t begin = 0, end; !known && (end = text.find('\n', begin)) != std::string::npos;
         begin = end + 1)
      known = record_of(text.substr(begin, end - begin)).has_value();
    if (!known) return entry.path().string();
  }
  return "";
}

ShareLock::ShareLock(const std::string& folder, int share, int shares, double patience) {
  make_folder(folder);
  const std::string name = fmt::format(".share-{}-of-{}.lock", share + 1, shares);
  fd_ = open_file(folder + "/" + name);
  const auto held_by_others = [&] {
    if (!lock_file(fd_)) return true;
    const std::string same_way = fmt::format("-of-{}.lock", shares);
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string other = entry.path().filename().string();
      if (!other.starts_with(".share-") || other.ends_with(same_way)) continue;
      const int fd = ::open(entry.path().c_str(), O_RDWR | O_CLOEXEC);
      const bool held = fd >= 0 && !lock_file(fd);
      if (fd >= 0) ::close(fd);
      if (held) return true;
    }
    return false;
  };
  constexpr double kBetweenTries = 0.1;
  for (double waited = 0; held_by_others(); waited += kBetweenTries) {
    if (waited >= patience) {
      ::close(fd_);
      throw InputError(folder, "", "another run that works on these cases",
                       "one run at a time (with any number of threads or ranks), or several runs that all "
                       "have their own --shard i/n");
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(kBetweenTries));
  }
}

ShareLock::~ShareLock() { ::close(fd_); }

GatherLock::GatherLock(const std::string& folder) : fd_(open_file(folder + "/.gather.lock")) {
  ::flock(fd_, LOCK_EX);
}

GatherLock::~GatherLock() { ::close(fd_); }

}  // namespace aberfit
