#include "aberfit/report/result_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <set>
#include <sstream>
#include <system_error>
#include <utility>

#include "aberfit/core/content_hash.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/report/result.h"

namespace aberfit {
namespace {

namespace fs = std::filesystem;

// Owner of the results: "command fit", then one line with hash and name per file.
constexpr const char* kManifest = ".aberfit-files";
constexpr const char* kCommand = "command";
constexpr const char* kResult = "result.json";

std::set<std::string> files_below(const fs::path& folder) {
  std::set<std::string> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    if (!entry.is_directory() || entry.is_symlink())
      files.insert(entry.path().lexically_relative(folder).generic_string());
  return files;
}

bool is_plain(const fs::path& file) { return fs::is_regular_file(fs::symlink_status(file)); }

std::string hash_of(const fs::path& file) { return content_hash(file_bytes(file.string()).value_or("")); }

// The files that a run left in its folder.
struct LastRun {
  std::string command;
  std::multimap<std::string, std::string> hash_of_name;  // two while files of two runs are exchanged

  static LastRun in(const fs::path& folder) {
    LastRun run;
    std::istringstream lines(file_bytes((folder / kManifest).string()).value_or(""));
    for (std::string line; std::getline(lines, line);) {
      const std::size_t blank = line.find(' ');
      if (blank == std::string::npos) continue;
      const std::string first = line.substr(0, blank), rest = line.substr(blank + 1);
      if (first == kCommand) {
        run.command = rest;
        continue;
      }
      const fs::path name = fs::path(rest).lexically_normal();
      // A run writes no names that lead out of the folder.
      if (!name.empty() && name.is_relative() && *name.begin() != "..")
        run.hash_of_name.emplace(name.generic_string(), first);
    }
    return run;
  }
  // The files of `part`, owned by `command`.
  static LastRun to_be(const fs::path& part, const std::string& command) {
    LastRun run{command, {}};
    for (const std::string& file : files_below(part))
      if (file != kManifest) run.hash_of_name.emplace(file, hash_of(part / file));
    return run;
  }
  std::string text() const {
    std::string lines = fmt::format("{} {}\n", kCommand, command);
    for (const auto& [name, hash] : hash_of_name) lines += fmt::format("{} {}\n", hash, name);
    return lines;
  }
  std::set<std::string> names() const {
    std::set<std::string> all;
    for (const auto& [name, hash] : hash_of_name) all.insert(name);
    return all;
  }
  // True if the file of that name is unchanged since this run.
  bool left(const fs::path& folder, const std::string& name) const {
    const auto [begin, end] = hash_of_name.equal_range(name);
    if (begin == end || !is_plain(folder / name)) return false;
    const std::string hash = hash_of(folder / name);
    return std::any_of(begin, end, [&](const auto& entry) { return entry.second == hash; });
  }
};

// Files that match a name of a claim, or the file in place of their folder.
std::vector<std::string> files_of(const fs::path& folder, const std::string& name) {
  const fs::path around = fs::path(name).parent_path();
  const auto is_there = [&](const fs::path& place) { return fs::exists(fs::symlink_status(folder / place)); };
  if (!around.empty() && is_there(around) && !fs::is_directory(folder / around))
    return {around.generic_string()};
  if (!name.ends_with('*'))
    return is_there(name) ? std::vector<std::string>{name} : std::vector<std::string>{};
  const std::string begin = fs::path(name.substr(0, name.size() - 1)).filename().string();
  std::vector<std::string> files;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / around, none))
    if (entry.path().filename().string().starts_with(begin) && !(entry.is_directory() && !entry.is_symlink()))
      files.push_back((around / entry.path().filename()).generic_string());
  return files;
}

// Files in the way of those that match `names`, except this command's own.
struct Obstacles {
  std::set<std::string> of_other, of_nobody;  // unchanged results of another command; all others
  std::string own, other;
  bool has_folder = false;

  template <typename Names>
  Obstacles(const fs::path& folder, const std::string& command, const Names& names) : own(command) {
    std::error_code error;
    if (!fs::is_directory(folder, error)) return;
    const LastRun last = LastRun::in(folder);
    other = last.command;
    for (const std::string& name : names)
      for (const std::string& file : files_of(folder, name)) {
        has_folder = has_folder || fs::is_directory(fs::symlink_status(folder / file));
        const bool left = last.left(folder, file);
        if (left && other == command) continue;
        (left ? of_other : of_nobody).insert(file);
      }
  }
  bool none() const { return of_other.empty() && of_nobody.empty(); }
  std::string told() const {
    std::vector<std::string> parts;
    if (!of_other.empty())
      parts.push_back(fmt::format("{} of `aberfit {}`", fmt::join(of_other, ", "), other));
    if (!of_nobody.empty())
      parts.push_back(
          fmt::format("{} (not written by `aberfit {}`, or changed since)", fmt::join(of_nobody, ", "), own));
    return fmt::format("{}", fmt::join(parts, "; "));
  }
};

constexpr const char* kWaysOut = "another folder with --output, or --force to replace them";

// True if the folder can be replaced: it has only plain files of one file system, and only folders of the
// last run.
bool can_be_made_anew(const fs::path& folder) {
  std::set<std::string> folders;
  for (const std::string& file : LastRun::in(folder).names())
    if (const fs::path name(file); name.has_parent_path()) folders.insert(name.begin()->string());
  const auto all_plain = [](const fs::path& in) {
    const fs::directory_iterator entries(in);
    return std::all_of(begin(entries), end(entries),
                       [](const auto& entry) { return is_plain(entry.path()); });
  };
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const bool ours = entry.is_directory() && !entry.is_symlink() &&
                      folders.contains(entry.path().filename().string()) && all_plain(entry.path());
    if (!is_plain(entry.path()) && !ours) return false;
  }
  return true;
}

// Links all files but those of this command's last run into `to`. They are in both places until the exchange,
// so a killed process loses nothing.
void keep_files_of_others(const fs::path& from, const std::string& command, const fs::path& to) {
  const LastRun last = LastRun::in(from);
  for (const std::string& file : files_below(from)) {
    if (file == kManifest || fs::exists(fs::symlink_status(to / file))) continue;
    if (last.command == command && last.left(from, file)) continue;
    fs::create_directories((to / file).parent_path());
    fs::create_hard_link(from / file, to / file);
  }
}

bool exchange(const fs::path& a, const fs::path& b) {
  return ::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0;
}

// Moves a file. Throws if `to` exists, unless it is to be replaced.
void put_file(const fs::path& from, const fs::path& to, bool replace) {
  if (to.has_parent_path()) {
    const fs::path around = to.parent_path();
    if (replace && fs::exists(fs::symlink_status(around)) && !fs::is_directory(around)) fs::remove(around);
    fs::create_directories(around);
  }
  if (!replace) {
    if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return;
    // Not every file system can do this.
    if (errno == EEXIST || fs::exists(fs::symlink_status(to)))
      throw fs::filesystem_error("", to, std::make_error_code(std::errc::file_exists));
  }
  fs::rename(from, to);
}

// Replaces file by file where folders cannot be exchanged (a mount point, the working folder of a shell, a
// folder with more than results). There is no result.json while the files belong to two runs.
void replace_files(const fs::path& from, const LastRun& run, const fs::path& to, bool force) {
  const LastRun last = LastRun::in(to);
  LastRun both = run;
  std::set<std::string> old;
  if (last.command == run.command)
    for (const auto& [name, hash] : last.hash_of_name)
      if (last.left(to, name)) both.hash_of_name.emplace(name, hash), old.insert(name);
  write_file((to / kManifest).string(), both.text());
  const std::set<std::string> files = run.names();
  if (old.contains(kResult) || (force && files.contains(kResult))) fs::remove(to / kResult);
  for (const std::string& file : old) fs::remove(to / file);
  for (const std::string& file : files)
    if (file != kResult) put_file(from / file, to / file, force);
  if (files.contains(kResult)) put_file(from / kResult, to / kResult, force);
  fs::rename(from / kManifest, to / kManifest);
}

bool holds_working_folder(const fs::path& folder) {
  const fs::path relative = fs::current_path().lexically_relative(folder);
  return !relative.empty() && *relative.begin() != "..";
}

[[noreturn]] void refuse(const std::string& folder, const std::string& found) {
  throw InputError(folder, "", found, "a folder to write to");
}

}  // namespace

void ResultFolder::look(const std::string& folder, const ResultClaim& claim) {
  if (folder.empty()) return;
  const Obstacles found(folder, claim.command, claim.names);
  if (!found.none() && (!claim.force || found.has_folder))
    throw InputError(folder, "", found.told(), found.has_folder ? "another folder with --output" : kWaysOut);
}

ResultFolder::ResultFolder(const std::string& folder, ResultClaim claim)
    : named_(folder), claim_(std::move(claim)) {
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
    look(folder_.string(), claim_);
    fs::remove_all(part_);  // left by a killed run
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

// The lock ends with the process in any case. If the last holder removes the file between our opening and
// locking it, we try again.
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
                       "one run at a time; wait for it, or name another folder with --output");
    }
    struct stat held, named;
    if (::fstat(lock_fd_, &held) == 0 && ::stat(lock_.c_str(), &named) == 0 && held.st_ino == named.st_ino)
      return;
    ::close(lock_fd_);
  }
}

// Moves the results to a place that the next run does not clear.
std::string ResultFolder::keep_aside() {
  fs::path aside;
  int k = 1;
  do {
    aside = folder_, aside += fmt::format("-{}", ++k);
  } while (fs::exists(fs::symlink_status(aside)));
  std::error_code error;
  fs::rename(part_, aside, error);
  if (error) aside = part_;
  part_.clear();
  return aside.string();
}

void ResultFolder::put_in_place() {
  const LastRun run = LastRun::to_be(part_, claim_.command);
  write_file((part_ / kManifest).string(), run.text());
  if (!fs::exists(folder_)) return fs::rename(part_, folder_);
  const Obstacles found(folder_, claim_.command, run.names());
  if (!found.none() && (!claim_.force || found.has_folder))
    throw InputError(
        named_, "",
        fmt::format("{}, which appeared meanwhile; the results are in {}", found.told(), keep_aside()),
        kWaysOut);
  bool exchanged = false;
  if (part_.parent_path() != folder_ && can_be_made_anew(folder_)) {
    try {
      keep_files_of_others(folder_, claim_.command, part_);
      fs::permissions(part_, fs::status(folder_).permissions());
      exchanged = exchange(part_, folder_);
    } catch (const fs::filesystem_error&) {  // a file system without links
    }
    // These files came between check and exchange.
    if (exchanged) keep_files_of_others(part_, claim_.command, folder_);
  }
  if (!exchanged) replace_files(part_, run, folder_, claim_.force);
  if (!found.none() && claim_.tell) claim_.tell(fmt::format("replaced in {}: {}", named_, found.told()));
}

void ResultFolder::show() {
  if (!wanted()) return;
  try {
    put_in_place();
    shown_ = true;
  } catch (const fs::filesystem_error& error) {
    refuse(named_, fmt::format("results that cannot be put there ({}); they are in {}",
                               error.code().message(), keep_aside()));
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
