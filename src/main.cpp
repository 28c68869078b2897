// The program: reads the command line, calls the library, prints what came and turns failures into exit
// codes.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/report/result.h"
#include "aberfit/study/read_study.h"
#include "aberfit/study/run.h"

namespace {

using nlohmann::ordered_json;

enum ExitCode { kDone = 0, kNotMet = 1, kBadInput = 2, kComputationFailed = 3 };

struct Arguments {
  std::string study_file;
  std::string output_directory;
  std::string coefficients_file;
  int threads = 0;
  bool no_plots = false, json = false, quiet = false;
};

// One line on standard error, rewritten in place and gone before anything else is printed.
class ProgressLine {
 public:
  explicit ProgressLine(bool wanted) : shown_(wanted && isatty(STDERR_FILENO) == 1) {}
  ~ProgressLine() { clear(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  bool shown() const { return shown_; }
  void show(const std::string& line) {
    fmt::print(stderr, "\r\x1b[K{}", line);
    std::fflush(stderr);
    dirty_ = true;
  }
  void clear() {
    if (dirty_) fmt::print(stderr, "\r\x1b[K");
    dirty_ = false;
  }

 private:
  bool shown_;
  bool dirty_ = false;
};

// out/<folder of the study> when the file has the usual name study.json, else out/<name of the file>.
std::string default_output_directory(const std::string& study_file) {
  const std::filesystem::path path = std::filesystem::absolute(study_file).lexically_normal();
  std::filesystem::path name = path.stem();
  if (path.filename() == "study.json" && path.parent_path().has_filename())
    name = path.parent_path().filename();
  return (std::filesystem::path("out") / name).string();
}

aberfit::RunOptions run_options(const Arguments& arguments, ProgressLine* progress) {
  aberfit::RunOptions options;
  options.threads = arguments.threads;
  options.plots = !arguments.no_plots;
  options.output_directory = arguments.output_directory;
  options.coefficients_file = arguments.coefficients_file;
  if (progress->shown()) options.progress = [progress](const std::string& line) { progress->show(line); };
  return options;
}

void print(const Arguments& arguments, const ordered_json& json, const std::string& table) {
  if (arguments.json)
    fmt::print("{}\n", json.dump(2));
  else
    fmt::print("{}{}", table, table.empty() || table.back() == '\n' ? "" : "\n");
}

void say_where(const Arguments& arguments) {
  if (!arguments.quiet) fmt::print(stderr, "results in {}\n", arguments.output_directory);
}

// A folder that cannot be written to is found out before the computing, not after it: by writing a file
// there. Leaves no trace, so that a run that fails later leaves none either.
void choose_output_directory(Arguments* arguments) {
  namespace fs = std::filesystem;
  if (arguments->output_directory.empty())
    arguments->output_directory = default_output_directory(arguments->study_file);
  const fs::path folder = fs::absolute(arguments->output_directory).lexically_normal();
  std::vector<fs::path> absent;  // innermost first
  std::error_code error;
  for (fs::path p = folder; p.has_relative_path() && !fs::exists(p, error); p = p.parent_path())
    absent.push_back(p);
  const auto remove_absent = [&absent] {
    std::error_code ignored;
    for (const fs::path& p : absent) fs::remove(p, ignored);  // only where empty
  };
  try {
    const fs::path probe = folder / (".aberfit-" + std::to_string(getpid()));
    aberfit::write_file(probe.string(), "");
    fs::remove(probe, error);
    remove_absent();
  } catch (const aberfit::InputError& failure) {
    remove_absent();
    throw aberfit::InputError(arguments->output_directory, "", failure.found(), "a folder to write to");
  }
}

int fit(Arguments arguments) {
  const aberfit::Study study = aberfit::read_study(arguments.study_file);
  choose_output_directory(&arguments);
  ProgressLine progress(!arguments.quiet);
  const aberfit::ResultDocument result = aberfit::run_fit(study, run_options(arguments, &progress));
  progress.clear();
  print(arguments, arguments.json ? to_json(result) : ordered_json(), summary_table(result, false));
  say_where(arguments);
  if (result.fit.status == aberfit::FitStatus::kFailed) return kComputationFailed;
  const bool met =
      result.fit.status == aberfit::FitStatus::kConverged && result.verdict == aberfit::Verdict::kEquivalent;
  return met ? kDone : kNotMet;
}

int verify(Arguments arguments) {
  const aberfit::Study study = aberfit::read_study(arguments.study_file);
  choose_output_directory(&arguments);
  ProgressLine progress(!arguments.quiet);
  std::string table;
  const ordered_json result = aberfit::run_verify(study, run_options(arguments, &progress), &table);
  progress.clear();
  print(arguments, result, table);
  say_where(arguments);
  return result.at("verdict") == to_string(aberfit::Verdict::kEquivalent) ? kDone : kNotMet;
}

template <typename Run>
int forward(const Arguments& arguments, Run run) {
  const aberfit::Study study = aberfit::read_study(arguments.study_file);
  ProgressLine progress(!arguments.quiet);
  std::string table;
  const ordered_json result = run(study, run_options(arguments, &progress), &table);
  progress.clear();
  print(arguments, result, table);
  return kDone;
}

int run(int argc, char** argv) {
  CLI::App app(
      "Equivalent aberration terms of rough mirrors: a surface of Zernike, Fourier and spherical terms whose "
      "traced focus is statistically equivalent to the Harvey-Shack scatter of a roughness specification.",
      "aberfit");
  app.set_version_flag("--version", std::string("aberfit ") + ABERFIT_VERSION);
  app.require_subcommand(1);
  app.fallthrough();  // common options may stand after the command
  app.footer(
      "Exit codes: 0 done (and equivalent where judged); 1 ran but not converged, different or undecided; "
      "2 bad input or usage; 3 the computation failed.");
  Arguments arguments;
  app.add_option("--threads", arguments.threads,
                 "Threads to use (default: all there are); results do not depend on it")
      ->check(CLI::Range(1, 65536))
      ->type_name("N");
  app.add_flag("--json", arguments.json, "Machine-readable result on standard output, nothing else there");
  app.add_flag("--quiet", arguments.quiet, "Nothing on standard error but errors");

  const auto command = [&](const char* name, const char* what) {
    CLI::App* sub = app.add_subcommand(name, what);
    sub->add_option("STUDY", arguments.study_file, "Study file (JSON); see `aberfit schema`")->required();
    return sub;
  };
  const auto output = [&](CLI::App* sub) {
    sub->add_option("-o,--output", arguments.output_directory,
                    "Folder for the results (default: out/<name of the study>)")
        ->type_name("DIR");
    sub->add_flag("--no-plots", arguments.no_plots, "Draw no pictures");
  };
  const auto coefficients = [&](CLI::App* sub) {
    sub->add_option("--coefficients", arguments.coefficients_file,
                    "Surface to trace (CSV as `fit` writes it), not a draw")
        ->type_name("FILE");
  };
  CLI::App* fit_command = command("fit", "Find the equivalent surface and judge it");
  output(fit_command);
  CLI::App* verify_command =
      command("verify", "Harvey-Shack and aberration-term branches side by side, no fit");
  output(verify_command);
  coefficients(verify_command);
  CLI::App* trace_command = command("trace", "Focal statistics of a surface, nothing else");
  coefficients(trace_command);
  CLI::App* check_command = command("check", "The resolved study, the model it needs and why; runs nothing");
  CLI::App* schema_command = app.add_subcommand("schema", "JSON Schema of the study format");

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kBadInput;  // --help and --version come here, too
  }
  if (*fit_command) return fit(arguments);
  if (*verify_command) return verify(arguments);
  if (*trace_command) return forward(arguments, aberfit::run_trace);
  if (*check_command) return forward(arguments, aberfit::run_check);
  if (*schema_command) fmt::print("{}\n", aberfit::study_schema().dump(2));
  return kDone;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const aberfit::InputError& error) {
    fmt::print(stderr, "aberfit: {}\n", error.what());
    return kBadInput;
  } catch (const std::exception& error) {
    fmt::print(stderr, "aberfit: the computation failed: {}\n", error.what());
    return kComputationFailed;
  }
}
