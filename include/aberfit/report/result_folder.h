#pragma once
#include <filesystem>
#include <string>

namespace aberfit {

/// A folder of results is one unit: the files of one run, whole, or what was there before. Files are written
/// to a place beside it and take its place all at once; what an earlier run wrote there goes, and files that
/// no run wrote stay. A second run into the same folder is refused while the first one lasts.
class ResultFolder {
 public:
  /// folder: empty for nothing to be written. Throws InputError where it cannot be written to or another run
  /// is at it: before the computing, and without a trace.
  explicit ResultFolder(const std::string& folder);
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

  bool wanted() const { return !folder_.empty(); }
  /// Where the files go until they are shown; empty where nothing is wanted.
  std::string path() const { return part_.string(); }
  /// Puts the files in place. Throws InputError where that fails, and says where they are then.
  void show();

 private:
  void lock();
  void leave();

  std::string named_;  // as the user knows it
  std::filesystem::path folder_, part_, lock_;
  std::filesystem::path made_;  // outermost folder that was made on the way; empty: none
  int lock_fd_ = -1;
  bool shown_ = false;
};

}  // namespace aberfit
