#pragma once
#include <string>
#include <utility>
#include <vector>

namespace aberfit {

/// The exit codes of the program.
enum class ExitCode {
  kDone = 0,      ///< finished; if judged, equivalent
  kNotMet = 1,    ///< different or undecided; without a verdict (psd, maps): not converged
  kBadInput = 2,  ///< or bad usage
  kComputationFailed = 3,
  kInterrupted = 4,  ///< by a signal or --time-limit: best so far, if any; a sweep keeps its cases
};

/// The command line; texts as typed, empty if nothing was typed.
struct CommandLine {
  std::string typed;                        ///< whole command line
  std::string study_file;                   ///< "-": standard input
  std::vector<std::string> changes;         ///< changes to the study, "/json/pointer=value"
  std::string output_directory;             ///< empty: out/<name of the study>/<command>
  bool force = false;                       ///< replace files that are in the way there
  std::string coefficients_file;            ///< verify, trace
  std::string arrays;                       ///< fit, trace, check: one of array_format_names
  double chart_seconds = 60;                ///< chart [s]
  std::vector<std::string> measured_files;  ///< psd
  /// psd: keys of a `psd` block of model "measured" with their texts, for each file and for the whole block.
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

// The commands of the program. Each reads its input, runs (commands/run.h), prints the table or the JSON on
// standard output, and returns an ExitCode. Progress and the folder of the results go to standard error.
// Failures are thrown, see core/errors.h.
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
ExitCode serve_command(CommandLine line);  // standard input and output, see commands/serve.h
/// The kinds of studies that `new` writes.
std::vector<std::string> starter_kinds();

/// Throws InputError if the file is known to be of a kind that the command does not use, and names the
/// command that does. Instead of a study it recognises a measured file, coefficients, a table of a PSD, a
/// result or an empty file; for "psd" all of these but a measured file. Unknown files are left to their
/// readers.
void require_right_file(const std::string& path, const std::string& command);
/// The command and its arguments for a file that was typed in place of a command; empty if the file's kind is
/// not known.
std::string command_for(const std::string& path);

}  // namespace aberfit
