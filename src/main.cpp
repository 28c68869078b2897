// The program: reads the command line, calls the library, prints what came and turns failures into exit
// codes.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <chrono>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "aberfit/chart/run_chart.h"
#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/report/result.h"
#include "aberfit/study/read_study.h"

namespace {

using nlohmann::ordered_json;

enum ExitCode { kDone = 0, kNotMet = 1, kBadInput = 2, kComputationFailed = 3 };

struct Arguments {
  std::string study_file;
  std::string output_directory;
  std::string coefficients_file;
  std::string chart_file;    // check
  bool paper_table = false;  // check
  std::vector<std::string> table_sigma, table_length, table_diameter;
  std::string table_wavelength;
  double chart_seconds = 60;                       // chart
  std::vector<std::string> measured_files;         // psd
  std::map<std::string, std::string> psd_options;  // psd: keys of a `psd` block of model "measured"
  int threads = 0;
  bool keep_lines = false;
  bool no_plots = false, json = false, quiet = false;
};

// On a terminal one line of standard error, rewritten in place and gone before anything else is printed; in
// a log a line now and then, where the work takes long.
class ProgressLine {
 public:
  explicit ProgressLine(bool wanted) : shown_(wanted), terminal_(isatty(STDERR_FILENO) == 1) {}
  ~ProgressLine() { clear(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  bool shown() const { return shown_; }
  void show(const std::string& line) {
    if (!terminal_) {
      const auto now = std::chrono::steady_clock::now();
      if (now - logged_ < kBetweenLines) return;
      logged_ = now;
      fmt::print(stderr, "{}\n", line);
    } else {
      fmt::print(stderr, "\r\x1b[K{}", line);
      dirty_ = true;
    }
    std::fflush(stderr);
  }
  void clear() {
    if (dirty_) fmt::print(stderr, "\r\x1b[K");
    dirty_ = false;
  }

 private:
  static constexpr std::chrono::seconds kBetweenLines{20};
  bool shown_, terminal_;
  bool dirty_ = false;
  std::chrono::steady_clock::time_point logged_ = std::chrono::steady_clock::now();
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
  options.chart_file = arguments.chart_file;
  options.chart_seconds = arguments.chart_seconds;
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
  const bool judged_well = result.map.has_value() || result.verdict == aberfit::Verdict::kEquivalent;
  const bool met = result.fit.status == aberfit::FitStatus::kConverged && judged_well;
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

// Options of `psd FILE`: each is the key of the study format of the same name.
struct PsdOption {
  const char* flag;
  const char* key;
  const char* type;
  const char* meaning;
  bool of_file = false;  // says something about a file, not about the estimate or the model
};
constexpr std::array kPsdOptions = {
    PsdOption{"--format", "format", "NAME",
              "dabam, profile, map, zygo, codev-int, fits, zemax-grid-sag (default: by content)", true},
    PsdOption{"--column", "column", "N", "profiles: which scan line, from 1", true},
    PsdOption{"--quantity", "quantity", "NAME", "profiles in columns: height or slope", true},
    PsdOption{"--of", "of", "NAME", "surface or wavefront", true},
    PsdOption{"--x-unit", "x_unit", "UNIT", "unit of the positions, where the file does not say", true},
    PsdOption{"--value-unit", "value_unit", "UNIT", "unit of heights or slopes, where the file does not say",
              true},
    PsdOption{"--pitch", "pitch", "LENGTH", "maps: distance of neighbouring points, e.g. \"0.1 mm\"", true},
    PsdOption{"--wavelength", "wavelength", "LENGTH", "of the instrument, for values in waves or radians",
              true},
    PsdOption{"--scale", "scale", "X", "factor on the heights", true},
    PsdOption{"--detrend", "detrend", "NAME", "none, polynomial (default), ellipse, zernike"},
    PsdOption{"--degree", "degree", "N", "of the polynomial or the Zernikes (default 2)"},
    PsdOption{"--window", "window", "NAME", "none, hann (default), hamming, blackman-harris, welch, tukey"},
    PsdOption{"--bins-per-decade", "bins_per_decade", "N", "logarithmic bins (default 12)"},
    PsdOption{"--confidence", "confidence", "P", "of the intervals, e.g. \"95 %\""},
    PsdOption{
        "--family", "family", "NAME",
        "auto (default), power-law, k-correlation, uniform, power-law-and-floor, k-correlation-and-floor, "
        "two-k-correlations"},
    PsdOption{"--f-min", "f_min", "FREQ", "lower edge of the band to fit, e.g. \"20 /m\""},
    PsdOption{"--f-max", "f_max", "FREQ", "upper edge of the band to fit, e.g. \"1 /mm\""},
};

// A number where the whole text is one, so that plain SI numbers do as in a study.
ordered_json option_value(const std::string& text) {
  std::int64_t whole = 0;
  double number = 0;
  const char *begin = text.data(), *end = begin + text.size();
  if (const auto [at, error] = std::from_chars(begin, end, whole); error == std::errc{} && at == end)
    return whole;
  if (const auto [at, error] = std::from_chars(begin, end, number); error == std::errc{} && at == end)
    return number;
  return text;
}

// What is measured: a study's measurement, or files with the options of the command line.
aberfit::MeasuredPsd measured(const Arguments& arguments, std::string* title) {
  const std::string& first = arguments.measured_files.front();
  if (std::filesystem::path(first).extension() == ".json") {
    if (arguments.measured_files.size() > 1 || !arguments.psd_options.empty() || arguments.keep_lines)
      throw aberfit::InputError("command line", "", "options or further files beside a study",
                                "the study alone: they are keys of its `psd` block");
    const aberfit::Study study = aberfit::read_study(first);
    *title = study.title;
    return aberfit::measured_psd_of(study);
  }
  ordered_json source = ordered_json::object(), block;
  for (const PsdOption& option : kPsdOptions)
    if (const auto given = arguments.psd_options.find(option.key); given != arguments.psd_options.end())
      (option.of_file ? source : block)[option.key] = option_value(given->second);
  for (const std::string& file : arguments.measured_files) {
    source["file"] = file;
    if (&file == &first)
      block.update(source);
    else
      block["further"].push_back(source);
  }
  if (arguments.keep_lines) block["find_lines"] = false;
  *title = std::filesystem::path(first).filename().string();
  return aberfit::read_measured(block, "command line", arguments.threads);
}

// Beside out/<study>, where the fit's result is.
std::string default_chart_directory(const std::string& study_file) {
  return default_output_directory(study_file) + "-chart";
}

int chart(Arguments arguments) {
  const aberfit::Study study = aberfit::read_study(arguments.study_file);
  if (arguments.output_directory.empty())
    arguments.output_directory = default_chart_directory(arguments.study_file);
  choose_output_directory(&arguments);
  ProgressLine progress(!arguments.quiet);
  std::string table;
  const ordered_json result = aberfit::run_chart(study, run_options(arguments, &progress), &table);
  progress.clear();
  print(arguments, result, table);
  say_where(arguments);
  return kDone;
}

// Ranges of the paper's table from the command line; the defaults where nothing is given.
aberfit::PaperTable paper_table(const Arguments& arguments) {
  aberfit::PaperTable table;
  const auto length = [](const std::string& option, const std::string& text) {
    double value = 0;
    try {
      value = aberfit::parse_quantity(text, aberfit::Dimension::kLength);
    } catch (const std::exception&) {
      value = 0;
    }
    if (!(value > 0))
      throw aberfit::InputError("command line", "", option + " \"" + text + "\"",
                                "a positive length with its unit, e.g. \"10 nm\"");
    return value;
  };
  const auto lengths = [&](const char* option, const std::vector<std::string>& texts,
                           std::vector<double>* values) {
    if (!texts.empty()) values->clear();
    for (const std::string& text : texts) values->push_back(length(option, text));
  };
  lengths("--sigma", arguments.table_sigma, &table.rms_heights);
  lengths("--correlation-length", arguments.table_length, &table.correlation_lengths);
  lengths("--diameter", arguments.table_diameter, &table.diameters);
  if (!arguments.table_wavelength.empty())
    table.wavelength = length("--wavelength", arguments.table_wavelength);
  return table;
}

// Without --chart the chart that `aberfit chart` would have written serves, if it is there and of this study.
ordered_json check(const aberfit::Study& study, aberfit::RunOptions options, std::string* table) {
  if (options.chart_file.empty()) {
    options.chart_file = (std::filesystem::path(default_chart_directory(study.path)) / "chart.json").string();
    options.chart_optional = true;
  }
  return aberfit::run_check(study, options, table);
}

int psd(Arguments arguments) {
  arguments.study_file = arguments.measured_files.front();
  ProgressLine progress(!arguments.quiet);
  if (progress.shown()) progress.show("measuring");
  std::string title, table;
  const aberfit::MeasuredPsd result = measured(arguments, &title);
  choose_output_directory(&arguments);
  const ordered_json json = aberfit::run_psd(result, title, run_options(arguments, &progress), &table);
  progress.clear();
  print(arguments, json, table);
  say_where(arguments);
  return result.result.status == aberfit::PsdFitStatus::kConverged ? kDone : kNotMet;
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
  CLI::App* psd_command = app.add_subcommand(
      "psd", "Measured profile or map -> PSD -> model with uncertainties, as a roughness block for a study");
  psd_command
      ->add_option("FILE", arguments.measured_files,
                   "Measured files of one surface (several: their bands are stitched), or one study (.json)")
      ->required();
  output(psd_command);
  for (const PsdOption& option : kPsdOptions)
    psd_command
        ->add_option_function<std::string>(
            option.flag,
            [&arguments, &option](const std::string& value) { arguments.psd_options[option.key] = value; },
            option.meaning)
        ->type_name(option.type);
  psd_command->add_flag("--keep-lines", arguments.keep_lines, "Leave periodic structure in the bins");
  CLI::App* chart_command = command(
      "chart", "Speed against accuracy on this scene: pupils, normals, operators, derivatives, terms");
  chart_command
      ->add_option("-o,--output", arguments.output_directory,
                   "Folder for the results (default: out/<name of the study>-chart)")
      ->type_name("DIR");
  chart_command->add_flag("--no-plots", arguments.no_plots, "Draw no pictures");
  chart_command
      ->add_option("--seconds", arguments.chart_seconds,
                   "About how long it may take, pictures left out (default: 60)")
      ->check(CLI::Range(0.1, 1e6))
      ->type_name("S");
  CLI::App* check_command = command(
      "check", "The resolved study, the model it needs and why, and what a fit will take; runs nothing");
  check_command
      ->add_option("--chart", arguments.chart_file,
                   "chart.json or its folder: the rates to predict with (default: that of out/<name of the "
                   "study>-chart, where it is of the same study)")
      ->type_name("FILE");
  CLI::Option* table = check_command->add_flag(
      "--paper-table", arguments.paper_table,
      "The paper's table of R = 2 sigma D/(1.22 lambda l_c), with kappa and both verdicts in each cell");
  const auto range = [&](const char* flag, std::vector<std::string>* values, const char* meaning) {
    check_command->add_option(flag, *values, meaning)->needs(table)->delimiter(',')->type_name("LENGTH,...");
  };
  range("--sigma", &arguments.table_sigma, "RMS heights of the table (default: 1 nm, 10 nm, 100 nm)");
  range("--correlation-length", &arguments.table_length,
        "Correlation lengths of the table (default: 1 um, 10 um, 1 mm)");
  range("--diameter", &arguments.table_diameter,
        "Aperture diameters of the table (default: 0.2 m, 0.4 m, 0.5 m, 1 m)");
  check_command
      ->add_option("--wavelength", arguments.table_wavelength, "Wavelength of the table (default: 500 nm)")
      ->needs(table)
      ->type_name("LENGTH");
  CLI::App* schema_command = app.add_subcommand("schema", "JSON Schema of the study format");

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kBadInput;  // --help and --version come here, too
  }
  if (*fit_command) return fit(arguments);
  if (*verify_command) return verify(arguments);
  if (*trace_command) return forward(arguments, aberfit::run_trace);
  if (*psd_command) return psd(arguments);
  if (*chart_command) return chart(arguments);
  if (*check_command)
    return forward(arguments, [&](const aberfit::Study& study, aberfit::RunOptions options, std::string* t) {
      if (arguments.paper_table) options.paper_table = paper_table(arguments);
      return check(study, options, t);
    });
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
