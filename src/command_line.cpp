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
  sub->add_option(
         "STUDY", line->study_file,
         "Study file (.json, or .jsonc with comments), or - for standard input; `aberfit new` writes "
         "one to begin from, `aberfit schema study` explains its keys")
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
  sub->add_option(
         "--pictures", line->pictures,
         "Files that pictures become, whatever the study says: auto (SVG for curves, PNG for maps), png, "
         "svg, pdf, or none")
      ->check(CLI::IsMember(picture_format_names()))
      ->type_name("FORMAT");
}
void add_arrays(CLI::App* sub, CommandLine* line) {
  sub->add_option(
         "--arrays", line->arrays,
         "Encircled energy, ring profile, PSF and OTF as numbers: npz (numpy), csv, fits (PSF and OTF), "
         "or none, whatever the study says")
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
                 "After this time, e.g. \"60 s\", \"5 min\" or \"2 h\", the fit ends with the best so far; "
                 "judging it and writing the files take their time after the limit; exit code 4");
  sub->footer(
      "A fit takes the roughness of the study, finds Zernike, Fourier or spherical terms whose focus has the "
      "encircled energies, widths and scatter of that roughness, and judges the surface on statistics that "
      "were not fitted. The first line says EQUIVALENT, DIFFERENT or UNDECIDED; the exit code is 0 for "
      "equivalent alone. A study with `target.map` is fitted to a measured map by least squares.\n\n"
      "The folder gets summary.txt and result.json, coefficients.csv (the terms), scatter.csv and "
      "scatter_psd.csv (what the terms leave to scatter), pictures, and the surface for other programs where "
      "`output.export` asks for it.\n\n"
      "Examples:\n"
      "  aberfit new specification && aberfit fit specification.jsonc\n"
      "  aberfit fit study.json --set \"/roughness/psd/rms=60 nm\" -o rougher");
}

void add_verify_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(app, "verify",
                                    "Harvey-Shack and aberration-term branches side by side, no fit", line);
  add_output(sub, line, kFolder);
  add_coefficients(sub, line);
  add_time_limit(sub, line);
  sub->footer(
      "Realisations of the roughness are traced and diffracted, and the mean of their focus is held against "
      "Harvey-Shack theory: two ways to the same numbers, neither of them fitted. Where they agree, the "
      "targets of a fit can be trusted.\n\n"
      "Example:\n"
      "  aberfit verify study.json -o verified");
}

void add_trace_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(app, "trace", "Focal statistics of a surface, nothing else", line);
  add_coefficients(sub, line);
  add_arrays_and_folder(sub, line,
                        "Folder for the arrays and the result (default: out/<name of the study>/trace)");
  add_time_limit(sub, line);
  sub->footer(
      "Says what one surface does to the focus: the surface of --coefficients, or a realisation of the "
      "roughness by the study's seed. Files are written where --arrays asks for them.\n\n"
      "Examples:\n"
      "  aberfit trace study.json --coefficients out/study/fit/coefficients.csv\n"
      "  aberfit trace study.json --arrays npz -o traced");
}

void add_psd_command(CLI::App* app, CommandLine* line, std::map<std::string, std::string>* texts) {
  CLI::App* sub = app->add_subcommand(
      "psd", "Measured profile or map -> PSD -> model with uncertainties, as a roughness block for a study");
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
      "Shape is taken off the measurement (--detrend), its PSD is estimated in bins, and a model is fitted "
      "to "
      "the bins with its uncertainties. The end of the text is a `roughness` block to paste into a study; "
      "roughness.json holds the same. What a file does not say itself - unit, pitch, wavelength of the "
      "instrument - is asked for by the option that says it.\n\n"
      "Examples:\n"
      "  aberfit psd part.dat\n"
      "  aberfit psd trace.csv --x-unit mm --value-unit nm --detrend ellipse\n"
      "  aberfit psd map.fits --pitch \"0.1 mm\" --aperture circle:diameter=95% --bands mid=1/mm..10/mm");
}

void add_chart_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(
      app, "chart", "Speed against accuracy on this scene: theories, models, whole fits, cuts of the band",
      line);
  add_output(sub, line, kFolder);
  sub->add_option("--seconds", line->chart_seconds,
                  "About how long it may take, pictures left out (default: 60)")
      ->check(CLI::Range(0.1, 1e6))
      ->type_name("S");
  add_time_limit(sub, line);
  sub->footer(
      "Every way to the study's statistics is timed and held against the most exact one of the scene. The "
      "table and the pictures show what a cheaper model, fewer terms or a cut of the band would cost in "
      "accuracy. --seconds says how long to try, --time-limit when to give up.\n\n"
      "Example:\n"
      "  aberfit chart study.json --seconds 20");
}

void add_check_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(
      app, "check",
      "The resolved study, the model it needs and why, and what a fit takes, by making one iteration", line);
  add_arrays_and_folder(sub, line,
                        "Folder for the arrays and the result (default: out/<name of the study>/check)");
  add_time_limit(sub, line);
  sub->footer(
      "The first thing to do with a new study: it says in seconds what the mean focus of the roughness is, "
      "whether rays are enough or waves are needed, how many terms a fit takes, and how long it will be. "
      "--json has the study with every default filled in, itself a study.\n\n"
      "Examples:\n"
      "  aberfit check study.json\n"
      "  aberfit check study.json --json --set \"/light/wavelength=10.6 um\"");
}

void add_solve_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(
      app, "solve", "Which roughness meets a budget: numbers of the PSD, from the study's `solve` block",
      line);
  add_output(sub, line, kFolder);
  add_time_limit(sub, line);
  sub->footer(
      "The block names one or two numbers of the roughness and the budgets that have to hold:\n"
      "  \"solve\": {\"for\": [\"/roughness/psd/rms\"],\n"
      "            \"so_that\": {\"ee80_diameter\": \"<= 0.6 arcsec\"}}\n\n"
      "Budgets, each with <= or >= and a quantity:\n"
      "  ee80_radius, ee80_diameter    any percent of the light: length, or angle on the sky\n"
      "  hew, fwhm, ensquared80_side   half-energy width, full width, side of a square\n"
      "  ee80_diameter@1mm             the same in a plane out of focus (but for hew)\n"
      "  strehl, tis, pssn, mtf@20/mm  Strehl ratio, scatter, image quality, contrast\n"
      "  bsdf@5deg                     stray light in a direction [1/sr]\n"
      "  rms_height, rms_slope         of the surface; of a band: rms_height@10/m-100/m\n"
      "  structure@10mm, scatter_rms   structure function, RMS scatter angle\n\n"
      "`\"ceilings\": {}` instead of `for` gives the most roughness in each octave of frequency and the "
      "A/f^B line of a drawing; `\"focus\": {\"file\": ...}` instead of `so_that` finds the roughness of a "
      "measured focus; `with` adds other mirrors, air and jitter; `confidence` asks for a share of all "
      "mirrors instead of their mean. `aberfit schema solve` explains every key.\n\n"
      "Examples:\n"
      "  aberfit new budget && aberfit solve budget.jsonc\n"
      "  aberfit solve study.json --set \"/solve/so_that/ee80_diameter=<= 1 arcsec\"");
}

void add_sweep_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = add_study_command(app, "sweep",
                                    "The studies that the `vary` block stands for, thousands of them", line);
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
  sub->footer(
      "`vary.over` names what takes other values, as a list or a range; every value comes with every other. "
      "Cases run over threads, ranks (mpirun) or job arrays. Each is recorded when it is done: started "
      "again, "
      "a sweep goes on where it was. `vary.run` says what is computed of each: check (the theory alone, the "
      "default), trace, fit or solve.\n\n"
      "Examples:\n"
      "  aberfit new sweep && aberfit sweep sweep.jsonc\n"
      "  mpirun -n 16 aberfit sweep study.json\n"
      "  aberfit sweep study.json --shard 2/8 --time-limit \"2 h\"");
}

void add_report_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = app->add_subcommand("report", "Put several results side by side in one page");
  sub->add_option("DIR", line->result_folders, "Folders of results")->required();
  sub->add_option("-o,--output", line->output_directory, "The page (default: comparison.html)")
      ->type_name("FILE");
  sub->add_flag("--force", line->force, "Write over a file that is already there");
  sub->footer(
      "The page has the answer of each result, what was asked and every number, where they differ, and links "
      "to the report.html of each. It needs no network and no other file.\n\n"
      "Example:\n"
      "  aberfit report out/mirror-a/fit out/mirror-b/fit");
}

void add_new_command(CLI::App* app, CommandLine* line) {
  CLI::App* sub = app->add_subcommand("new", "Write a study with comments to begin from");
  sub->add_option("KIND", line->starter_kind, "What it is for; without it the kinds are listed")
      ->type_name(fmt::format("KIND:{{{}}}", fmt::join(starter_kinds(), ",")));
  sub->add_option("FILE", line->starter_file,
                  "Study to write, a name ending in .jsonc (default: <kind>.jsonc); of the kinds profile and "
                  "map also the measured file, which the study then names");
  sub->add_flag("--force", line->force, "Write over a file that is already there");
  sub->footer(
      "Comments in the study say what each block is for, what to change, which command to run and how it "
      "ends.\n\n"
      "Examples:\n"
      "  aberfit new\n"
      "  aberfit new specification telescope.jsonc\n"
      "  aberfit new profile my_profile.csv");
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
  app->set_version_flag("--version", std::string("aberfit ") + ABERFIT_VERSION, "Say the version");
  app->require_subcommand(1);
  app->fallthrough();  // common options may stand after the command
  app->footer(
      "Exit codes:\n"
      "  0  done (and equivalent where judged)\n"
      "  1  ran, but not converged, different or undecided; no solution\n"
      "  2  bad input or usage\n"
      "  3  the computation failed\n"
      "  4  stopped by a signal or by --time-limit; fit and sweep keep the best so far\n\n"
      "Text is as wide as the terminal, or as COLUMNS says; NO_COLOR and TERM=dumb keep it plain.\n\n"
      "Examples:\n"
      "  aberfit new specification     a study to begin from\n"
      "  aberfit check specification.jsonc\n"
      "  aberfit fit specification.jsonc");
  app->add_option("--threads", line->threads,
                  "Threads to use (default: all there are); results do not depend on it")
      ->check(CLI::Range(1, 65536))
      ->type_name("N");
  app->add_flag("--json", line->json, "Machine-readable result on standard output, nothing else there");
  app->add_flag("--quiet", line->quiet, "Nothing on standard error but errors");
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
