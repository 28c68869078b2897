#pragma once
#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "aberfit/cases/case_record.h"

namespace aberfit {

/// One worker's records: a file of JSON Lines that only grows. Each line is handed to the system as it comes,
/// so a killed process loses none, and forced to the disk at most a second later, so a machine that loses its
/// power loses a second. A worker takes the first file worker-0001.jsonl, ... that no other has, so killed
/// and started again there are no more files than there ever were workers; a last line that was cut short is
/// taken off first. Use from many threads.
class CaseJournal {
 public:
  /// The file is made with the first record. folder: made where it is missing.
  explicit CaseJournal(std::string folder);
  ~CaseJournal();
  CaseJournal(const CaseJournal&) = delete;
  CaseJournal& operator=(const CaseJournal&) = delete;

  /// Throws InputError where it cannot be written; what is in the file then ends with a whole line.
  void add(const CaseRecord& record);
  /// Forces what was added to the disk.
  void sync();

 private:
  void open();

  std::string folder_, path_;
  std::mutex mutex_;
  int fd_ = -1;
  bool dirty_ = false;
  std::chrono::steady_clock::time_point synced_ = std::chrono::steady_clock::now();
};

/// All records of a folder, files in the order of their names; of cases with the same id the first, or the
/// first that did not fail. Lines that are not whole are passed over. damaged: whole lines that are no
/// records.
std::vector<CaseRecord> read_journals(const std::string& folder, std::size_t* damaged);

/// The first journal of a folder that no sweep can have written - there is something in it, but no record nor
/// the beginning of one -, which one that goes on there would add to; empty where there is none.
std::string foreign_journal(const std::string& folder);

/// Keeps others from the same work: one holder of a share of the cases, and no two ways of sharing them at a
/// time. Ends with the process.
class ShareLock {
 public:
  /// share: 0 to shares - 1. Waits `patience` [s] for one who is about to end; throws InputError.
  ShareLock(const std::string& folder, int share, int shares, double patience = 5);
  ~ShareLock();
  ShareLock(const ShareLock&) = delete;
  ShareLock& operator=(const ShareLock&) = delete;

 private:
  int fd_ = -1;
};

/// Waits until nobody else writes the results of `folder`; holds the others off while it lives.
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
