// Describes every command and option with its meaning, its text for --help and its example. The help, the
// manual page and the completions of shells are made from this description (manual.cpp).
#include "command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <utility>

#include "aberfit/core/output_formats.h"
#include "aberfit/measured/read_measurement.h"

namespace aberfit::internal {
namespace {

// An option of `psd FILE` sets the key of the same name in the study format.
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
    PsdOption{"--column", "column", "N", "profiles: number of the scan line, from 1", true},
    PsdOption{"--quantity", "quantity", "NAME", "profiles in columns: height or slope", true},
    PsdOption{"--of", "of", "NAME", "surface or wavefront", true},
    PsdOption{"--x-unit", "x_unit", "UNIT", "unit of the positions, where the file does not say", true},
    PsdOption{"--value-unit", "value_unit", "UNIT",
              "unit of heights or slopes, where the file does not say; heights also in waves", true},
    PsdOption{"--pitch", "pitch", "LENGTH",
              "distance between neighbouring points, e.g. \"0.1 mm\": for maps, and for profiles whose "
              "positions are rounded or missing",
              true},
    PsdOption{"--columns", "columns", "N",
              "text maps: samples per row, where a row continues over several lines", true},
    PsdOption{"--first-row", "first_row", "NAME",
              "text maps and .npy: where the first row is, top (default) or bottom", true},
    PsdOption{"--wavelength", "wavelength", "LENGTH",
              "wavelength of the instrument, for values in waves or radians", true},
    PsdOption{"--hdu", "hdu", "NAME|N", "FITS: name or number of the image (0: primary)", true},
    PsdOption{"--plane", "plane", "K", "FITS and NumPy: plane of a cube, from 1", true},
    PsdOption{"--scale", "scale", "X", "factor on the heights", true},
    PsdOption{
        "--invalid", "invalid", "X,...",
        "values that mark a missing sample, in the unit of the file's values, e.g. 0 or 0,-9999; may be "
        "repeated",
        true},
    PsdOption{
        "--aperture", "aperture", "SHAPE",
        "clear aperture: circle:diameter=95%, annulus:outer=48mm,inner=30%, rectangle:width=90%,height=80%, "
        "for profiles interval:length=90%; centre=x,y is counted from the middle",
        true},
    PsdOption{"--mask", "mask", "FILE",
              "maps: text or FITS map of the same size; points with 0 or nan are left out", true},
    PsdOption{"--erode", "erode", "N", "number of samples removed along the rim and the rims of holes", true},
    PsdOption{"--outliers", "outliers", "NAME",
              "samples that differ from their surroundings: warn (default), reject, keep"},
    PsdOption{"--detrend", "detrend", "NAME",
              "shape to remove: none, polynomial (default), ellipse, zernike"},
    PsdOption{"--degree", "degree", "N", "degree of the polynomial or the Zernikes (default 2)"},
    PsdOption{"--window", "window", "NAME",
              "window: none, hann (default), hamming, blackman-harris, welch, tukey"},
    PsdOption{"--bins-per-decade", "bins_per_decade", "N",
              "number of logarithmic bins per decade (default 12)"},
    PsdOption{"--confidence", "confidence", "P", "confidence of the intervals, e.g. \"95 %\""},
    PsdOption{"--family", "family", "NAME",
              "model to fit: auto (default), power-law, k-correlation, uniform, power-law-and-floor, "
              "k-correlation-and-floor, two-k-correlations"},
    PsdOption{"--f-min", "f_min", "FREQ", "lower edge of the band to fit, e.g. \"20 /m\""},
    PsdOption{"--f-max", "f_max", "FREQ", "upper edge of the band to fit, e.g. \"1 /mm\""},
    PsdOption{"--bands", "bands", "NAME=FREQ..FREQ,...",
              "bands in which RMS height and slope are reported, e.g. low=0.1/mm..1/mm,mid=1/mm..10/mm"},
};

// The option takes one value each time, so that the study may follow it.
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
                  "Study file (.json, or .jsonc with comments), or - for standard input; `aberfit new` "
                  "writes one to start from, `aberfit schema study` explains its keys")
      ->required();
  add_changes(sub, line);
  return sub;
}

void add_force(CLI::App* sub, CommandLine* line) {
  sub->add_flag("--force", line->force,
                "Replace files in the result folder that this command did not write itself, and list them");
}
void add_output(CLI::App* sub, CommandLine* line, const char* which_folder) {
  sub->add_option("-o,--output", line->output_directory, which_folder)->type_name("DIR");
  add_force(sub, line);
  sub->add_option("--pictures", line->pictures,
                  "Format of pictures, instead of the study's: auto (SVG for curves, PNG for maps), png, "
                  "svg, pdf, or none")
      ->check(CLI::IsMember(picture_format_names()))
      ->type_name("FORMAT");
}
void add_arrays(CLI::App* sub, CommandLine* line) {
  sub->add_option("--arrays", line->arrays,
                  "Format of encircled energy, ring profile, PSF and OTF as numbers, instead of the study's: "
                  "npz (numpy), csv, fits (PSF and OTF), or none")
      ->check(CLI::IsMember(array_format_names()))
      ->type_name("FORMAT");
}
// These commands write only arrays.
void add_arrays_and_folder(CLI::App* sub, CommandLine* line, const char* which_folder) {
  add_arrays(sub, line);
  sub->add_option("-o,--output", line->output_directory, which_folder)->type_name("DIR");
  add_force(sub, line);
}
constexpr const char* kFolder = "Folder for the results (default: out/<name of the study>/<command>)";

void add_coefficients(CLI::App* sub, CommandLine* line) {
  sub->add_option("--coefficients", line->coefficients_file,
                  "Surface to trace (CSV as `fit` writes it) instead of a realisation of the roughness")
      ->type_name("FILE");
}

constexpr const char* kHardLimit =
    "After this time, e.g. \"60 s\", \"5 min\" or \"2 h\", the command ends and writes nothing; exit code 4";
void add_time_limit(CLI::App* sub, CommandLine* line, const char* meaning = kHardLimit) {
  sub->add_option("--time-limit", line->time_limit, meaning)->type_name("TIME");
}

void add_fit_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(app, "fit", "Find the equivalent surface and judge it", line);
  add_output(sub, line, kFolder);
  add_arrays(sub, line);
  add_time_limit(sub, line,
                 "After this time, e.g. \"60 s\", \"5 min\" or \"2 h\", the fit ends with the best result so "
                 "far, which is then judged and written; exit code 4");
  sub->footer(
      "A fit takes the roughness of the study, finds Zernike, Fourier or spherical terms whose focus has the "
      "encircled energies, widths and scatter of that roughness, and judges the surface on statistics that "
      "were not fitted. The first line says EQUIVALENT, DIFFERENT or UNDECIDED; the exit code is 0 only for "
      "EQUIVALENT. With `target.map` the terms are fitted to a measured map by least squares.\n\nThe result "
      "folder contains summary.txt and result.json, coefficients.csv (the terms), scatter.csv and "
      "scatter_psd.csv (the roughness left to scatter) and pictures. With `output.export` it also contains "
      "the surface for other programs.\n\nExamples:\n  aberfit new specification && aberfit fit "
      "specification.jsonc\n  aberfit fit study.json --set \"/roughness/psd/rms=60 nm\" -o rougher");
}

void add_verify_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(app, "verify",
                                    "Compare Harvey-Shack theory with random surfaces, without a fit", line);
  add_output(sub, line, kFolder);
  add_coefficients(sub, line);
  add_time_limit(sub, line);
  sub->footer(
      "Realisations of the roughness are traced and diffracted, and their mean focus is compared with "
      "Harvey-Shack theory. Neither is fitted to the other. Where they agree, the targets of a fit can be "
      "trusted.\n\nExample:\n  aberfit verify study.json -o verified");
}

void add_trace_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(app, "trace", "Compute the focal statistics of a surface", line);
  add_coefficients(sub, line);
  add_arrays_and_folder(sub, line,
                        "Folder for the arrays and the result (default: out/<name of the study>/trace)");
  add_time_limit(sub, line);
  sub->footer(
      "Computes the focus of one surface: that of --coefficients, or the realisation of the roughness with "
      "the study's seed. Files are written only with --arrays.\n\nExamples:\n  aberfit trace study.json "
      "--coefficients out/study/fit/coefficients.csv\n  aberfit trace study.json --arrays npz -o traced");
}

void add_psd_command(CLI::App* app, CommandLine* line, std::map<std::string, std::string>* texts) {
  CLI::App* sub = app->add_subcommand(
      "psd",
      "Estimate the PSD of a measured profile or map and fit a model, as a roughness block for a study");
  sub->add_option("FILE", line->measured_files,
                  "Measured files of one surface (several: their bands are stitched), or one study (.json, "
                  ".jsonc, or - for standard input)")
      ->required();
  add_changes(sub, line);
  add_output(sub, line, kFolder);
  add_time_limit(sub, line);
  for (const PsdOption& option : kPsdOptions)
    sub->add_option_function<std::string>(
           option.flag, [texts, &option](const std::string& value) { (*texts)[option.key] = value; },
           option.meaning ? option.meaning : measured_format_list() + " (default: by content)")
        ->type_name(option.type)
        // Repeated lists become one list; repeating any other option is an error.
        ->multi_option_policy(std::string_view(option.key) == "invalid" ? CLI::MultiOptionPolicy::Join
                                                                        : CLI::MultiOptionPolicy::Throw);
  sub->add_flag("--keep-lines", line->keep_lines, "Leave periodic structure in the bins");
  sub->footer(
      "The shape is removed from the measurement (--detrend), the PSD is estimated in bins, and a model with "
      "uncertainties is fitted to the bins. The text ends with a `roughness` block to paste into a study; "
      "roughness.json contains the same. If a file does not state its unit, pitch or wavelength, the program "
      "names the option to use.\n\nExamples:\n  aberfit psd part.dat\n  aberfit psd trace.csv --x-unit mm "
      "--value-unit nm --detrend ellipse\n  aberfit psd map.fits --pitch \"0.1 mm\" --aperture "
      "circle:diameter=95% --bands mid=1/mm..10/mm");
}

void add_chart_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(
      app, "chart",
      "Compare the speed and accuracy of theories, models, fits and cuts of the band on this scene", line);
  add_output(sub, line, kFolder);
  sub->add_option("--seconds", line->chart_seconds,
                  "Approximate time to spend, without pictures (default: 60)")
      ->check(CLI::Range(0.1, 1e6))
      ->type_name("S");
  add_time_limit(sub, line);
  sub->footer(
      "Every method for the study's statistics is timed and compared with the most exact one. The table and "
      "the pictures show how much accuracy a cheaper model, fewer terms or a cut of the band would cost. "
      "--seconds sets how long to try, --time-limit when to give up.\n\nExample:\n  aberfit chart study.json "
      "--seconds 20");
}

void add_check_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(
      app, "check",
      "Show the complete study, the model it needs and why, and the cost of a fit from one iteration", line);
  add_arrays_and_folder(sub, line,
                        "Folder for the arrays and the result (default: out/<name of the study>/check)");
  add_time_limit(sub, line);
  sub->footer(
      "Run this first on a new study. It shows in seconds the mean focus of the roughness, whether rays are "
      "enough or waves are needed, and the number of terms and the time of a fit. --json contains the study "
      "with every default filled in; it is itself a study.\n\nExamples:\n  aberfit check study.json\n  "
      "aberfit check study.json --json --set \"/light/wavelength=10.6 um\"");
}

void add_solve_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(
      app, "solve", "Find the roughness that meets a budget, by the study's `solve` block", line);
  add_output(sub, line, kFolder);
  add_time_limit(sub, line);
  sub->footer(
      "The block names one or two unknown numbers of the roughness and the budgets that have to hold:\n  "
      "\"solve\": {\"for\": [\"/roughness/psd/rms\"],\n            \"so_that\": {\"ee80_diameter\": \"<= 0.6 "
      "arcsec\"}}\n\nBudgets, each with <= or >= and a quantity:\n  ee80_radius, ee80_diameter    any "
      "percent of the energy: length, or angle on the sky\n  hew, fwhm, ensquared80_side   half-energy "
      "width, full width, side of a square\n  ee80_diameter@1mm             the same in a plane out of focus "
      "(not hew)\n  strehl, tis, pssn, mtf@20/mm  Strehl ratio, scatter, image quality, contrast\n  "
      "bsdf@5deg                     stray light in a direction [1/sr]\n  rms_height, rms_slope         of "
      "the surface; of a band: rms_height@10/m-100/m\n  structure@10mm, scatter_rms   structure function, "
      "RMS scatter angle\n\n`\"ceilings\": {}` instead of `for` finds the largest roughness of each octave "
      "of frequency and the A/f^B line of a drawing; `\"focus\": {\"file\": ...}` instead of `so_that` finds "
      "the roughness of a measured focus; `with` adds other mirrors, air and jitter; with `confidence` a "
      "fraction of all mirrors has to meet the budgets instead of their mean. `aberfit schema solve` "
      "explains every key.\n\nExamples:\n  aberfit new budget && aberfit solve budget.jsonc\n  aberfit solve "
      "study.json --set \"/solve/so_that/ee80_diameter=<= 1 arcsec\"");
}

void add_sweep_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub =
      add_study_command(app, "sweep", "Run all studies of the `vary` block, up to thousands", line);
  add_output(sub, line, kFolder);
  sub->add_option("--shard", line->shard,
                  "Run only part of the cases: i/n is the i-th of n parts; array/n takes i from the job "
                  "array of SLURM, PBS or SGE (default: as SLURM or SGE say)")
      ->type_name("I/N");
  add_time_limit(sub, line,
                 "After this time, e.g. \"2 h\", no further case starts and fits end; exit code 4");
  sub->add_flag("--gather", line->gather_only, "Run nothing; only collect the recorded cases");
  sub->add_flag("--retry", line->retry_failed, "Run failed cases again");
  sub->footer(
      "`vary.over` names the keys to vary and their values, as a list or a range; all combinations are run. "
      "Cases are distributed over threads, ranks (mpirun) or job arrays. Each case is recorded when it is "
      "done, so a sweep that is started again continues. `vary.run` sets what is computed for each: check "
      "(theory only, the default), trace, fit or solve.\n\nExamples:\n  aberfit new sweep && aberfit sweep "
      "sweep.jsonc\n  mpirun -n 16 aberfit sweep study.json\n  aberfit sweep study.json --shard 2/8 "
      "--time-limit \"2 h\"");
}

void add_report_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = app->add_subcommand("report", "Put several results side by side in one page");
  sub->add_option("DIR", line->result_folders, "Folders of results")->required();
  sub->add_option("-o,--output", line->output_directory, "The page (default: comparison.html)")
      ->type_name("FILE");
  sub->add_flag("--force", line->force, "Overwrite an existing file");
  sub->footer(
      "The page has the verdict of each result, and all settings and numbers in which they differ. It links "
      "to the report.html of each result. It needs no network and no other file.\n\nExample:\n  aberfit "
      "report out/mirror-a/fit out/mirror-b/fit");
}

void add_new_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = app->add_subcommand("new", "Write a commented study to start from");
  sub->add_option("KIND", line->starter_kind, "Kind of study; without it the kinds are listed")
      ->type_name(fmt::format("KIND:{{{}}}", fmt::join(starter_kinds(), ",")));
  sub->add_option("FILE", line->starter_file,
                  "Name of the study to write, ending in .jsonc (default: <kind>.jsonc); for the kinds "
                  "profile and map also the measured file, which the study then names");
  sub->add_flag("--force", line->force, "Overwrite an existing file");
  sub->footer(
      "Comments in the study explain each block, what to change, which command to run and what its result "
      "is.\n\nExamples:\n  aberfit new\n  aberfit new specification telescope.jsonc\n  aberfit new profile "
      "my_profile.csv");
}

void add_serve_command(CLI::App* app) {
  CLI::App* sub = app->add_subcommand("serve", "Answer requests of another program, one JSON object a line");
  sub->add_flag("--stdio")->description("Requests on standard input, answers on standard output")->required();
  sub->footer(
      "Editors, web pages and agents start this program once and send it requests. Each gets lines of "
      "progress and one line with the result. Nothing listens on a network.\n\n"
      "  {\"id\": 1, \"method\": \"fit\", \"study\": {...}}   also check, verify, trace, psd, solve, chart\n"
      "  {\"id\": 2, \"method\": \"check\", \"file\": \"study.json\", \"set\": {\"/roughness/psd/rms\": \"20 "
      "nm\"}}\n"
      "  {\"id\": 3, \"method\": \"schema\"}   or with \"of\": \"results\"\n"
      "  {\"id\": 4, \"method\": \"cancel\", \"of\": 1}\n\n"
      "Example:\n"
      "  aberfit serve --stdio < requests.jsonl > answers.jsonl");
}

void add_schema_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub =
      app->add_subcommand("schema", "Explain a key of the study, or print the JSON Schema of all of them");
  sub->add_option(
      "KEY", line->schema_key,
      "Key to explain, e.g. roughness/psd or margin; \"study\" lists the blocks, \"results\" is the "
      "JSON Schema of results, results/fit/scene a block of them. Without it: the JSON Schema of the "
      "study format");
  sub->footer(
      "An editor that knows JSON Schema completes and checks a study that has "
      "`\"$schema\": \"./aberfit.schema.json\"` beside that file.\n\n"
      "Examples:\n"
      "  aberfit schema roughness/psd\n"
      "  aberfit schema results/fit/equivalence\n"
      "  aberfit schema > aberfit.schema.json");
}

void add_common_options(CLI::App* app, CommandLine* line) {
  app->set_help_flag("-h,--help", "Print this text");
  app->set_version_flag("--version", std::string("aberfit ") + ABERFIT_VERSION, "Print the version");
  app->require_subcommand(1);
  app->fallthrough();  // common options may stand after the command
  app->footer(
      "Exit codes:\n  0  done (and equivalent where judged)\n  1  ran, but not converged, different or "
      "undecided; no solution\n  2  bad input or usage\n  3  the computation failed\n  4  stopped by "
      "--time-limit, fit and sweep also by Ctrl-C; these two keep the\n     best so far\n\nText is as wide "
      "as the terminal, or as COLUMNS says; NO_COLOR and TERM=dumb remove colours.\n\nExamples:\n"
      "  aberfit new specification     a study to start from\n  aberfit check specification.jsonc\n"
      "  aberfit fit specification.jsonc");
  app->add_option("--threads", line->threads, "Number of threads (default: all); results do not depend on it")
      ->check(CLI::Range(1, 65536))
      ->type_name("N");
  app->add_flag("--json", line->json, "Print only the machine-readable result to standard output");
  app->add_flag("--quiet", line->quiet, "Print only errors to standard error");
}

}  // namespace

void describe_commands(CLI::App* app, TypedCommand* typed) {
  CommandLine* line = &typed->line;
  add_common_options(app, line);
  add_new_command(app, line);
  add_check_command(app, line);
  add_fit_command(app, line);
  add_solve_command(app, line);
  add_psd_command(app, line, &typed->psd_texts);
  add_verify_command(app, line);
  add_trace_command(app, line);
  add_sweep_command(app, line);
  add_report_command(app, line);
  add_chart_command(app, line);
  add_schema_command(app, line);
  add_serve_command(app);
  app->add_subcommand("manual", "The manual page, or the completion of a shell")
      ->group("")  // only the build uses it, so it is not shown
      ->add_option("FORM", typed->manual_form)
      ->required();
}

// The order is that of kPsdOptions, not that of the command line.
void take_psd_options(TypedCommand* typed) {
  for (const PsdOption& option : kPsdOptions)
    if (const auto given = typed->psd_texts.find(option.key); given != typed->psd_texts.end())
      (option.of_file ? typed->line.psd_of_file : typed->line.psd_of_block).push_back(*given);
}

}  // namespace aberfit::internal
