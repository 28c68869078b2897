// The command line: declares the options, calls the command and turns failures into exit codes.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <exception>
#include <map>
#include <new>
#include <string>
#include <vector>

#include "aberfit/commands/program.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/memory.h"
#include "aberfit/measured/read_measurement.h"
#include "aberfit/report/array_format.h"

namespace {

using aberfit::CommandLine;
using aberfit::ExitCode;

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
              nullptr,  // the list of them
              true},
    PsdOption{"--column", "column", "N", "profiles: which scan line, from 1", true},
    PsdOption{"--quantity", "quantity", "NAME", "profiles in columns: height or slope", true},
    PsdOption{"--of", "of", "NAME", "surface or wavefront", true},
    PsdOption{"--x-unit", "x_unit", "UNIT", "unit of the positions, where the file does not say", true},
    PsdOption{"--value-unit", "value_unit", "UNIT",
              "unit of heights or slopes, where the file does not say; heights also in waves", true},
    PsdOption{
        "--pitch", "pitch", "LENGTH",
        "distance of neighbouring points, e.g. \"0.1 mm\": of maps, and of profiles whose positions are "
        "rounded or left out",
        true},
    PsdOption{"--columns", "columns", "N", "text maps: samples of a row that goes over several lines", true},
    PsdOption{"--first-row", "first_row", "NAME", "text maps and .npy: top (default) or bottom", true},
    PsdOption{"--wavelength", "wavelength", "LENGTH", "of the instrument, for values in waves or radians",
              true},
    PsdOption{"--hdu", "hdu", "NAME|N", "FITS: the image, by name or number (0 the primary)", true},
    PsdOption{"--plane", "plane", "K", "FITS and NumPy: which plane of a cube, from 1", true},
    PsdOption{"--scale", "scale", "X", "factor on the heights", true},
    PsdOption{
        "--invalid", "invalid", "X,...",
        "values that mark a missing sample, in the unit of the file's values, e.g. 0 or 0,-9999; may be "
        "repeated",
        true},
    PsdOption{"--aperture", "aperture", "SHAPE",
              "clear aperture: circle:diameter=95%, annulus:outer=48mm,inner=30%, "
              "rectangle:width=90%,height=80%, profiles interval:length=90%; centre=x,y from the middle",
              true},
    PsdOption{"--mask", "mask", "FILE", "maps: text or FITS map of the same size; 0 or nan is left out",
              true},
    PsdOption{"--erode", "erode", "N", "samples taken off the rim and the rims of holes", true},
    PsdOption{"--outliers", "outliers", "NAME",
              "samples that stand out of their surroundings: warn (default), reject, keep"},
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
    PsdOption{"--bands", "bands", "NAME=FREQ..FREQ,...",
              "RMS height and slope of bands, e.g. low=0.1/mm..1/mm,mid=1/mm..10/mm"},
};

// One value each time, so that the study may stand behind it.
void add_changes(CLI::App* sub, CommandLine* line) {
  sub->add_option(
         "--set", line->changes,
         "Change the study before it is read, e.g. --set \"/roughness/psd/rms=60 nm\"; may be repeated")
      ->allow_extra_args(false)
      ->type_name("/POINTER=VALUE");
}

CLI::App* add_study_command(CLI::App* app, const char* name, const char* what, CommandLine* line) {
  CLI::App* sub = app->add_subcommand(name, what);
  sub->add_option("STUDY", line->study_file,
                  "Study file (JSON), or - for standard input; see `aberfit schema`")
      ->required();
  add_changes(sub, line);
  return sub;
}

void add_force(CLI::App* sub, CommandLine* line) {
  sub->add_flag(
      "--force", line->force,
      "Replace files of the folder that stand in the way of results and are not this command's own, "
      "and say which");
}
void add_output(CLI::App* sub, CommandLine* line, const char* which_folder) {
  sub->add_option("-o,--output", line->output_directory, which_folder)->type_name("DIR");
  add_force(sub, line);
  sub->add_flag("--no-plots", line->no_plots, "Draw no pictures");
}
void add_arrays(CLI::App* sub, CommandLine* line) {
  sub->add_option(
         "--arrays", line->arrays,
         "Encircled energy, ring profile, PSF and OTF as numbers: npz (numpy), csv, fits (PSF and OTF), "
         "or none, whatever the study says")
      ->check(CLI::IsMember(aberfit::array_format_names()))
      ->type_name("FORMAT");
}
// Commands that write nothing else.
void add_arrays_and_folder(CLI::App* sub, CommandLine* line, const char* which_folder) {
  add_arrays(sub, line);
  sub->add_option("-o,--output", line->output_directory, which_folder)->type_name("DIR");
  add_force(sub, line);
}
constexpr const char* kFolder = "Folder for the results (default: out/<name of the study>/<command>)";

void add_coefficients(CLI::App* sub, CommandLine* line) {
  sub->add_option("--coefficients", line->coefficients_file,
                  "Surface to trace (CSV as `fit` writes it), not a draw")
      ->type_name("FILE");
}

CLI::App* add_psd_command(CLI::App* app, CommandLine* line, std::map<std::string, std::string>* texts) {
  CLI::App* sub = app->add_subcommand(
      "psd", "Measured profile or map -> PSD -> model with uncertainties, as a roughness block for a study");
  sub->add_option("FILE", line->measured_files,
                  "Measured files of one surface (several: their bands are stitched), or one study (.json, "
                  "or - for standard input)")
      ->required();
  add_changes(sub, line);
  add_output(sub, line, kFolder);
  for (const PsdOption& option : kPsdOptions)
    sub->add_option_function<std::string>(
           option.flag, [texts, &option](const std::string& value) { (*texts)[option.key] = value; },
           option.meaning ? option.meaning : aberfit::measured_format_list() + " (default: by content)")
        ->type_name(option.type)
        // Lists that are given one after the other are one list; repeating another option is an error.
        ->multi_option_policy(std::string_view(option.key) == "invalid" ? CLI::MultiOptionPolicy::Join
                                                                        : CLI::MultiOptionPolicy::Throw);
  sub->add_flag("--keep-lines", line->keep_lines, "Leave periodic structure in the bins");
  return sub;
}

// In the order of kPsdOptions, whatever that of the command line.
void take_psd_options(const std::map<std::string, std::string>& texts, CommandLine* line) {
  for (const PsdOption& option : kPsdOptions)
    if (const auto given = texts.find(option.key); given != texts.end())
      (option.of_file ? line->psd_of_file : line->psd_of_block).push_back(*given);
}

CLI::App* add_chart_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(
      app, "chart", "Speed against accuracy on this scene: theories, models, whole fits, cuts of the band",
      line);
  add_output(sub, line, kFolder);
  sub->add_option("--seconds", line->chart_seconds,
                  "About how long it may take, pictures left out (default: 60)")
      ->check(CLI::Range(0.1, 1e6))
      ->type_name("S");
  return sub;
}

CLI::App* add_check_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(
      app, "check",
      "The resolved study, the model it needs and why, and what a fit takes, by making one iteration", line);
  add_arrays_and_folder(sub, line,
                        "Folder for the arrays and the result (default: out/<name of the study>/check)");
  CLI::Option* table = sub->add_flag(
      "--paper-table", line->paper_table,
      "The paper's table of R = 2 sigma D/(1.22 lambda l_c), with kappa and both verdicts in each cell");
  const auto range = [&](const char* flag, std::vector<std::string>* values, const char* meaning) {
    sub->add_option(flag, *values, meaning)->needs(table)->delimiter(',')->type_name("LENGTH,...");
  };
  range("--sigma", &line->table_sigma, "RMS heights of the table (default: 1, 10, 100, 1000 nm)");
  range("--correlation-length", &line->table_length,
        "Correlation lengths of the table (default: 1, 10, 100 um)");
  range("--diameter", &line->table_diameter, "Aperture diameters of the table (default: 0.2, 0.5, 1 m)");
  sub->add_option("--wavelength", line->table_wavelength, "Wavelength of the table (default: 500 nm)")
      ->needs(table)
      ->type_name("LENGTH");
  return sub;
}

void add_time_limit(CLI::App* sub, CommandLine* line, const char* meaning) {
  sub->add_option("--time-limit", line->time_limit, meaning)->type_name("TIME");
}

CLI::App* add_sweep_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(app, "sweep",
                                    "The studies that the `vary` block stands for, over threads, ranks "
                                    "(mpirun -n N aberfit sweep ...) or job "
                                    "arrays; started again it goes on where it was",
                                    line);
  add_output(sub, line, kFolder);
  sub->add_option(
         "--shard", line->shard,
         "Only these cases: i/n the i-th of n runs; array/n the one that the job array of SLURM, PBS or "
         "SGE says (default: what SLURM or SGE say)")
      ->type_name("I/N");
  add_time_limit(sub, line,
                 "After this time, e.g. \"2 h\", no further case is begun and fits end; exit code 4");
  sub->add_flag("--gather", line->gather_only, "Run nothing, only gather what is recorded so far");
  sub->add_flag("--retry", line->retry_failed, "Run cases that failed once more");
  return sub;
}

void add_common_options(CLI::App* app, CommandLine* line) {
  app->set_version_flag("--version", std::string("aberfit ") + ABERFIT_VERSION);
  app->require_subcommand(1);
  app->fallthrough();  // common options may stand after the command
  app->footer(
      "Exit codes: 0 done (and equivalent where judged); 1 ran but not converged, different or undecided; "
      "2 bad input or usage; 3 the computation failed; 4 a fit or sweep stopped by a signal or by "
      "--time-limit, with the best so far.");
  app->add_option("--threads", line->threads,
                  "Threads to use (default: all there are); results do not depend on it")
      ->check(CLI::Range(1, 65536))
      ->type_name("N");
  app->add_flag("--json", line->json, "Machine-readable result on standard output, nothing else there");
  app->add_flag("--quiet", line->quiet, "Nothing on standard error but errors");
}

// What stands where a command should; the parser would only say that one is missing.
void require_known_command(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  if (std::find(names.begin(), names.end(), argv[1]) != names.end()) return;
  const std::string for_file = aberfit::command_for(argv[1]);
  throw aberfit::InputError("command line", "", fmt::format("the command \"{}\"", argv[1]),
                            (for_file.empty() ? "" : fmt::format("`aberfit {}`, or another of ", for_file)) +
                                fmt::format("{}", fmt::join(names, ", ")));
}

ExitCode run(int argc, char** argv) {
  CLI::App app(
      "Equivalent aberration terms of rough mirrors: a surface of Zernike, Fourier and spherical terms whose "
      "traced focus is statistically equivalent to the Harvey-Shack scatter of a roughness specification.",
      "aberfit");
  CommandLine line;
  std::map<std::string, std::string> psd_texts;
  add_common_options(&app, &line);
  CLI::App* fit = add_study_command(&app, "fit", "Find the equivalent surface and judge it", &line);
  add_output(fit, &line, kFolder);
  add_arrays(fit, &line);
  add_time_limit(fit, &line,
                 "After this time, e.g. \"60 s\", \"5 min\" or \"2 h\", the fit ends with the best so far; "
                 "judging it and writing the files take their time after the limit; exit code 4");
  CLI::App* verify = add_study_command(
      &app, "verify", "Harvey-Shack and aberration-term branches side by side, no fit", &line);
  add_output(verify, &line, kFolder);
  add_coefficients(verify, &line);
  CLI::App* trace = add_study_command(&app, "trace", "Focal statistics of a surface, nothing else", &line);
  add_coefficients(trace, &line);
  add_arrays_and_folder(trace, &line,
                        "Folder for the arrays and the result (default: out/<name of the study>/trace)");
  CLI::App* psd = add_psd_command(&app, &line, &psd_texts);
  CLI::App* chart = add_chart_command(&app, &line);
  CLI::App* check = add_check_command(&app, &line);
  CLI::App* solve = add_study_command(
      &app, "solve", "Which roughness meets a budget: numbers of the PSD, from the study's `solve` block",
      &line);
  add_output(solve, &line, kFolder);
  CLI::App* sweep = add_sweep_command(&app, &line);
  app.add_subcommand("schema", "JSON Schema of the study format");

  require_known_command(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? ExitCode::kDone
                                : ExitCode::kBadInput;  // --help and --version come here, too
  }
  take_psd_options(psd_texts, &line);
  for (const CLI::App* command : app.get_subcommands())
    if (!line.study_file.empty()) aberfit::require_right_file(line.study_file, command->get_name());
  for (const std::string& file : line.measured_files) aberfit::require_right_file(file, "psd");
  if (*fit) return aberfit::fit_command(line);
  if (*verify) return aberfit::verify_command(line);
  if (*trace) return aberfit::trace_command(line);
  if (*psd) return aberfit::psd_command(line);
  if (*chart) return aberfit::chart_command(line);
  if (*check) return aberfit::check_command(line);
  if (*solve) return aberfit::solve_command(line);
  if (*sweep) return aberfit::sweep_command(line);
  return aberfit::schema_command();
}

}  // namespace

int main(int argc, char** argv) {
  aberfit::keep_freed_memory();
  try {
    return int(run(argc, argv));
  } catch (const aberfit::InputError& error) {
    fmt::print(stderr, "aberfit: {}\n", error.what());
    return int(ExitCode::kBadInput);
  } catch (const aberfit::FieldError& error) {  // commands name the file; without it the field is still told
    fmt::print(stderr, "aberfit: {}\n", error.what());
    return int(ExitCode::kBadInput);
  } catch (const aberfit::Interrupted& error) {
    fmt::print(stderr, "aberfit: {}; nothing is written\n", error.what());
    return int(ExitCode::kInterrupted);
  } catch (const std::bad_alloc&) {
    fmt::print(stderr,
               "aberfit: the computation failed: not enough memory; fewer terms or rays, or a larger margin, "
               "take less\n");
    return int(ExitCode::kComputationFailed);
  } catch (const std::exception& error) {
    fmt::print(stderr, "aberfit: the computation failed: {}\n", error.what());
    return int(ExitCode::kComputationFailed);
  }
}
