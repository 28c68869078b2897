#include "aberfit/chart/check.h"

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/method/map_terms.h"
#include "aberfit/method/measured_part.h"
#include "aberfit/report/check_report.h"
#include "aberfit/report/result.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/read_study.h"
#include "array_files.h"
#include "map_fit.h"
#include "output_directory.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

namespace {

double positive_length(const std::string& option, const std::string& text) {
  double value = 0;
  try {
    value = parse_quantity(text, Dimension::kLength);
  } catch (const std::exception&) {
    value = 0;
  }
  if (!(value > 0))
    throw InputError("command line", "", option + " \"" + text + "\"",
                     "a positive length with its unit, e.g. \"10 nm\"");
  return value;
}

// Ranges of the paper's table from the command line; the defaults where nothing is given.
PaperTable paper_table(const CommandLine& line) {
  PaperTable table;
  const auto lengths = [&](const char* option, const std::vector<std::string>& texts,
                           std::vector<double>* values) {
    if (!texts.empty()) values->clear();
    for (const std::string& text : texts) values->push_back(positive_length(option, text));
  };
  lengths("--sigma", line.table_sigma, &table.rms_heights);
  lengths("--correlation-length", line.table_length, &table.correlation_lengths);
  lengths("--diameter", line.table_diameter, &table.diameters);
  if (!line.table_wavelength.empty())
    table.wavelength = positive_length("--wavelength", line.table_wavelength);
  return table;
}

RunOptions check_options(const CommandLine& line, ProgressLine* progress) {
  RunOptions options = run_options(line, progress);
  options.measure_iteration = true;
  if (line.paper_table) options.paper_table = paper_table(line);
  return options;
}

// The light that theory promises, and the report beside it.
template <typename Report>
void write_theory(const Study& study, const RunOptions& options, ArrayFormat format,
                  const std::vector<double>& planes, ResultFolder& folder, Report* report) {
  const int threads = context_of(options).threads;
  std::unique_ptr<FocalLight> theory;
  double core_sigma = 0;
  if (study.psd) {
    const Groundwork ground = with_fields_of(study, [&] { return lay_groundwork(study); });
    theory = target_light(study, ground, make_pupil(study.aperture, study.trace.pupil), threads);
    core_sigma = ground.core_sigma;
  }
  write_arrays(study, format, theory.get(), nullptr, planes, core_sigma, folder.path(), &report->warnings);
  write_file(folder.path() + "/summary.txt", summary_table(*report));
  write_file(folder.path() + "/result.json", to_json(*report, resolved_study(study)).dump(2) + "\n");
  folder.show();
}

}  // namespace

CheckReport run_check(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  const ArrayFormat format = wanted_arrays(study, options);
  ResultFolder folder(format == ArrayFormat::kNone ? "" : options.output_directory,
                      claim_of_arrays("check", options, format));
  CheckReport report = with_fields_of(
      study, [&] { return make_check(study, context_of(options), options.measure_iteration); });
  report.title = study.title;
  if (options.paper_table) report.paper_table = paper_cells(*options.paper_table, study.mirror.focal_length);
  if (folder.wanted())
    write_theory(study, options, format, planes_of(statistics_of(report.fitted)), folder, &report);
  return report;
}

MapCheckReport run_map_check(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  const ArrayFormat format = wanted_arrays(study, options);
  ResultFolder folder(format == ArrayFormat::kNone ? "" : options.output_directory,
                      claim_of_arrays("check", options, format));
  const LoadedMap loaded = load_map(study);
  const TermSet terms = with_fields_of(study, [&] { return map_terms(study); });
  MapCheckReport report = make_map_check(loaded.map, terms);
  report.title = study.title;
  report.warnings = loaded.warnings;
  if (study.psd)
    report.shares = with_fields_of(study, [&] {
      return lay_out_part(study, terms, part_band(study, terms, loaded.map), context_of(options).threads)
          .ground.shares;
    });
  if (folder.wanted()) write_theory(study, options, format, {}, folder, &report);
  return report;
}

ExitCode check_command(CommandLine line) {
  const Study study = read_study(line.study_file, line.changes);
  ProgressLine progress(!line.quiet);
  RunOptions options = check_options(line, &progress);
  choose_arrays_directory(study, options, "check", &line);
  options.output_directory = line.output_directory;
  const auto show = [&](const auto& report) {
    progress.clear();
    print(line, to_json(report, resolved_study(study)), summary_table(report));
    if (wanted_arrays(study, options) != ArrayFormat::kNone) say_where(line);
  };
  if (study.map)
    show(run_map_check(study, options));
  else
    show(run_check(study, options));
  return ExitCode::kDone;
}

}  // namespace aberfit
