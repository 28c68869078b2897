#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace aberfit {

/// What a run is about to write, known before it computes anything.
struct ResultClaim {
  std::string command;             ///< whose results they are, e.g. "fit"
  std::vector<std::string> names;  ///< in the folder: "result.json"; "plots/contour*" is all that begins so
  bool force = false;              ///< replace what stands in the way
  std::function<void(const std::string&)> tell = {};  ///< hears in a line what was replaced; may be empty
};

/// A folder of results is one unit: the files of one run of one command, whole, or what was there before.
/// Files are written to a place beside it and take its place all at once. What an earlier run of the same
/// command wrote there goes, if it is as that run left it: `.aberfit-files` in the folder names the command
/// and has a hash of each of its files. Everything else - results of other commands, results that were
/// changed since, files of the user - stays byte for byte; where one stands in the way of a result, the run
/// is refused. A second run into the same folder is refused while the first one lasts.
class ResultFolder {
 public:
  /// folder: empty for nothing to be written. Throws InputError where it cannot be written to, something is
  /// in the way, or another run is at it: before the computing, and without a trace.
  ResultFolder(const std::string& folder, ResultClaim claim);
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

  /// The first look that the constructor takes, for whoever computes before there is a folder to write to:
  /// throws InputError where something is in the way and the claim does not replace it.
  static void look(const std::string& folder, const ResultClaim& claim);

  bool wanted() const { return !folder_.empty(); }
  /// Where the files go until they are shown; empty where nothing is wanted.
  std::string path() const { return part_.string(); }
  /// Puts the files in place. Throws InputError where that fails, or where something has come in the way
  /// since, and says where the results are then.
  void show();

 private:
  void lock();
  void leave();
  std::string keep_aside();
  void put_in_place();

  std::string named_;  // as the user knows it
  ResultClaim claim_;
  std::filesystem::path folder_, part_, lock_;
  std::filesystem::path made_;  // outermost folder that was made on the way; empty: none
  int lock_fd_ = -1;
  bool shown_ = false;
};

}  // namespace aberfit
