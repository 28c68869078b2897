#pragma once
#include <string>
#include <utility>
#include <vector>

namespace aberfit {

/// How the program ends.
enum class ExitCode {
  kDone = 0,      ///< and equivalent, where judged
  kNotMet = 1,    ///< ran, but different or undecided; not converged where nothing is judged (psd, maps)
  kBadInput = 2,  ///< or bad usage
  kComputationFailed = 3,
  kInterrupted = 4,  ///< by a signal or --time-limit: the best so far, if any; of a sweep the cases so far
};

/// What the command line says; texts as typed, empty where nothing was.
struct CommandLine {
  std::string typed;                        ///< the whole of it
  std::string study_file;                   ///< "-": standard input
  std::vector<std::string> changes;         ///< of the study, "/json/pointer=value"
  std::string output_directory;             ///< empty: out/<name of the study>/<command>
  bool force = false;                       ///< replace what stands in the way there
  std::string coefficients_file;            ///< verify, trace
  std::string arrays;                       ///< fit, trace, check: one of array_format_names
  double chart_seconds = 60;                ///< chart [s]
  std::vector<std::string> measured_files;  ///< psd
  /// psd: keys of a `psd` block of model "measured" with their texts; those of each file, and the others.
  std::vector<std::pair<std::string, std::string>> psd_of_file, psd_of_block;
  bool keep_lines = false;                         ///< psd
  std::string shard;                               ///< sweep: "2/8", "array/8"
  bool gather_only = false, retry_failed = false;  ///< sweep
  std::vector<std::string> result_folders;         ///< report
  std::string time_limit;                          ///< "60 s"; empty: none
  std::string schema_key;                          ///< schema: "roughness/psd"; empty: the whole as JSON
  std::string starter_kind, starter_file;          ///< new; empty: the list, <kind>.jsonc
  int threads = 0;                                 ///< 0: all there are
  std::string pictures;                            ///< one of picture_format_names
  bool json = false, quiet = false;
};

// The commands of the program: each reads its input, runs (commands/run.h), prints the table or the JSON on
// standard output, progress and where the results are on standard error, and returns an ExitCode. Failures
// are thrown, see core/errors.h.
ExitCode fit_command(CommandLine line);
ExitCode verify_command(CommandLine line);
ExitCode trace_command(CommandLine line);
ExitCode psd_command(CommandLine line);
ExitCode chart_command(CommandLine line);
ExitCode check_command(CommandLine line);
ExitCode solve_command(CommandLine line);
ExitCode sweep_command(CommandLine line);
ExitCode report_command(CommandLine line);
ExitCode schema_command(CommandLine line);
ExitCode new_command(CommandLine line);
/// The kinds of studies that `new` writes.
std::vector<std::string> starter_kinds();

/// Throws InputError where the file is known to be of another kind than the command works with, and names the
/// command that does: a measured file, coefficients, a table of a PSD, a result or an empty file in place of
/// a study; for "psd", all of these but a measured file. Files that are not known are left to their readers.
void require_right_file(const std::string& path, const std::string& command);
/// The command and its arguments for a file that stands where a command should; empty where it is not known.
std::string command_for(const std::string& path);

}  // namespace aberfit
