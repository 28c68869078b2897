#pragma once
#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "aberfit/cases/case_record.h"

namespace aberfit {

/// One worker's records: a file of JSON Lines that only grows. Each line goes to the system at once, so a
/// killed process loses none. It is forced to the disk at most a second later, so a power failure loses one
/// second. A worker takes the first file worker-0001.jsonl, ... that no other worker holds. So restarts do
/// not add files beyond the largest number of workers. An incomplete last line is removed first. Thread-safe.
class CaseJournal {
 public:
  /// The first record creates the file. folder: created if missing.
  explicit CaseJournal(std::string folder);
  ~CaseJournal();
  CaseJournal(const CaseJournal&) = delete;
  CaseJournal& operator=(const CaseJournal&) = delete;

  /// Throws InputError if it cannot be written; the file then ends with a whole line.
  void add(const CaseRecord& record);
  /// Forces the added records to the disk.
  void sync();

 private:
  void open();

  std::string folder_, path_;
  std::mutex mutex_;
  int fd_ = -1;
  bool dirty_ = false;
  std::chrono::steady_clock::time_point synced_ = std::chrono::steady_clock::now();
};

/// All records of a folder, files in the order of their names. For the same id it keeps the first without
/// failure, else the first. damaged: number of complete lines that are no records.
std::vector<CaseRecord> read_journals(const std::string& folder, std::size_t* damaged);

/// The first journal of a folder that no sweep can have written: it is not empty and has no record and no
/// beginning of one. A continued sweep would add to it. Empty if there is none.
std::string foreign_journal(const std::string& folder);

/// Prevents others from the same work: each part of the cases has one holder, and all holders use the same
/// number of parts. Ends with the process.
class ShareLock {
 public:
  /// share: 0 to shares - 1. Waits `patience` [s] for a holder that is about to end; throws InputError.
  ShareLock(const std::string& folder, int share, int shares, double patience = 5);
  ~ShareLock();
  ShareLock(const ShareLock&) = delete;
  ShareLock& operator=(const ShareLock&) = delete;

 private:
  int fd_ = -1;
};

/// Waits until no other process writes the results of `folder`; blocks the others while it exists.
class GatherLock {
 public:
  explicit GatherLock(const std::string& folder);
  ~GatherLock();
  GatherLock(const GatherLock&) = delete;
  GatherLock& operator=(const GatherLock&) = delete;

 private:
  int fd_ = -1;
};

}  // namespace aberfit
