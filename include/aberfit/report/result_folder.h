#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace aberfit {

/// The files that a run will write, known before it computes anything.
struct ResultClaim {
  std::string command;             ///< owner of the results, e.g. "fit"
  std::vector<std::string> names;  ///< in the folder: "result.json"; "plots/contour*" is a prefix
  bool force = false;              ///< replaces files in the way
  std::function<void(const std::string&)> tell = {};  ///< gets one line on what was replaced; may be empty
};

/// A folder of results is one unit: all files of one run of one command, or the previous content. Files are
/// written to a folder beside it, which takes its place at once. Unchanged results of an earlier run of the
/// same command are removed; `.aberfit-files` in the folder names the command and has a hash of each of its
/// files. All other files (results of other commands, changed results, files of the user) stay byte for byte.
/// A run is refused if one of them is in the way of a result, or while another run uses the folder.
class ResultFolder {
 public:
  /// folder: empty if nothing is to be written. Throws InputError, and leaves no trace, if it cannot be
  /// written to, something is in the way, or another run uses it.
  ResultFolder(const std::string& folder, ResultClaim claim);
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

  /// The constructor's first check, for callers that compute before they have a folder. Throws InputError if
  /// something is in the way and the claim does not replace it.
  static void look(const std::string& folder, const ResultClaim& claim);

  bool wanted() const { return !folder_.empty(); }
  /// Folder for the files until show(); empty if nothing is wanted.
  std::string path() const { return part_.string(); }
  /// Puts the files in place. Throws InputError, with the place of the results, if that fails or something
  /// is now in the way.
  void show();

 private:
  void lock();
  void leave();
  std::string keep_aside();
  void put_in_place();

  std::string named_;  // name given by the user
  ResultClaim claim_;
  std::filesystem::path folder_, part_, lock_;
  std::filesystem::path made_;  // outermost folder created; empty: none
  int lock_fd_ = -1;
  bool shown_ = false;
};

}  // namespace aberfit
