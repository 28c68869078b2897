#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/psd_report.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/measured_psd.h"
#include "aberfit/study/read_study.h"
#include "answers.h"
#include "interrupt.h"
#include "output_directory.h"
#include "psd_options.h"
#include "result_files.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

namespace {

using nlohmann::ordered_json;

// The first measurement of a psd block; null if there is none.
const MeasuredPsd* find_measured(const RoughnessModel& node) {
  if (const auto* measured = std::get_if<MeasuredPsd>(&node.model)) return measured;
  if (const auto* sum = std::get_if<RoughnessSum>(&node.model))
    for (const RoughnessModel& part : sum->parts)
      if (const MeasuredPsd* measured = find_measured(part)) return measured;
  return nullptr;
}

ordered_json roughness_block(const MeasuredPsd& measured) {
  return {{"psd", psd_block(roughness_model(measured.result.model))}};
}

ordered_json psd_json(const PsdReport& report, const MeasuredPsd& measured) {
  return to_json(report, psd_block(RoughnessModel{measured}), roughness_block(measured));
}

// The measurement of a study, or files with the options of the command line.
MeasuredPsd measured_by(const CommandLine& line, std::string* title, std::shared_ptr<const Study>* of_study) {
  const std::string& first = line.measured_files.front();
  if (first == "-" || first.ends_with(".json") || first.ends_with(".jsonc")) {
    if (line.measured_files.size() > 1 || !line.psd_of_file.empty() || !line.psd_of_block.empty() ||
        line.keep_lines)
      throw InputError("command line", "", "options or further files beside a study",
                       "the study alone, because they are keys of its `psd` block");
    *of_study = std::make_shared<const Study>(read_study(first, line.changes));
    *title = (*of_study)->title;
    return measured_psd_of(**of_study);
  }
  if (!line.changes.empty())
    throw InputError(kCommandLine, "--set \"" + line.changes.front() + "\"", "measured files, but no study",
                     "the options of `aberfit psd`, or --set beside a study");
  *title = std::filesystem::path(first).filename().string();
  return read_measured(psd_options_block(line), kCommandLine, line.threads);
}

ResultClaim claim_of_psd(const RunOptions& options) {
  return claim_of("psd", options, {"psd.csv", "bands.csv", "roughness.json"}, wanted_pictures(options),
                  {"psd", "structure_function", "data"});
}

// study: of the measurement; null: it was given without one.
void write(const MeasuredPsd& measured, const RunOptions& options, const Study* study, ResultFolder* folder,
           PsdReport* report) {
  if (!folder->wanted()) return;
  const std::string to = folder->path() + "/";
  auto drawn = draw_pictures(*report, to, wanted_pictures(options), &report->warnings);
  const ordered_json roughness = roughness_block(measured);
  write_file(to + "psd.csv", psd_csv(*report));
  write_file(to + "bands.csv", bands_csv(*report));
  write_file(to + "roughness.json", roughness.dump(2) + "\n");
  const ordered_json document = psd_json(*report, measured);
  write_result(folder->path(), options,
               {page_of(*report, roughness), document, study ? typed_study(*study) : document["request"],
                std::move(drawn)});
  folder->show();
}

}  // namespace

const MeasuredPsd& measured_psd_of(const Study& study) {
  const MeasuredPsd* measured = study.roughness ? find_measured(*study.roughness) : nullptr;
  if (!measured)
    throw InputError(study.path, "/roughness/psd", "a roughness without a measurement",
                     fmt::format("a psd of model \"measured\", or the measured file itself (`aberfit psd "
                                 "FILE`); `aberfit check {}` shows the roughness of this study",
                                 study.path));
  return *measured;
}

PsdReport run_psd(const MeasuredPsd& measured, const std::string& title, const RunOptions& options,
                  const Study* study) {
  ResultFolder results(options.output_directory, claim_of_psd(options));
  PsdReport report;
  report.title = title;
  report.files.push_back(measured.source.file);
  for (const MeasuredFile& file : measured.further) report.files.push_back(file.file);
  report.data = measured.data;
  report.clear = measured.clear;
  report.clear.resize(report.data.size());
  report.estimate = measured.estimate;
  report.fit = measured.result;
  report.surface = surface_psd(report.estimate, report.fit);
  report.line = drawing_line(report.estimate, report.fit.f_min, report.fit.f_max);
  for (const Measurement& data : report.data)
    report.differences.push_back(std::visit(
        [&](const auto& surface) { return height_differences(surface, report.estimate.options.detrend); },
        data));
  for (const FrequencyBand& band : measured.bands)
    report.bands.push_back(band_content(report.surface, report.estimate.kind, band));
  report.as_measured.exponent = std::nan("");
  if (std::any_of(report.fit.warnings.begin(), report.fit.warnings.end(),
                  [](const Warning& warning) { return warning.code == "rms-not-as-measured"; }))
    report.as_measured =
        line_as_measured(report.surface, report.estimate.kind, report.fit.f_min, report.fit.f_max);
  report.warnings = measured.estimate.warnings;
  report.warnings.insert(report.warnings.end(), measured.result.warnings.begin(),
                         measured.result.warnings.end());
  report.provenance = provenance_of(measured, options);
  if (study) report.provenance.inputs = provenance_of(*study, options).inputs;
  write(measured, options, study, &results, &report);
  return report;
}

Answer answer_psd(const MeasuredPsd& measured, const std::string& title, const RunOptions& options,
                  const Study* study) {
  const PsdReport report = run_psd(measured, title, options, study);
  const auto kept = study ? std::make_shared<const Study>(*study) : nullptr;
  Answer answer{measured.result.status == PsdFitStatus::kConverged ? ExitCode::kDone : ExitCode::kNotMet,
                page_of(report, roughness_block(measured))};
  answer.document = [=] { return psd_json(report, measured); };
  answer.save = [=](const RunOptions& there) {
    ResultFolder folder(there.output_directory, claim_of_psd(there));
    PsdReport written = report;
    write(measured, there, kept.get(), &folder, &written);
  };
  return answer;
}

ExitCode psd_command(CommandLine line) {
  const HardLimit limit(line.time_limit);
  line.study_file = line.measured_files.front();
  ProgressLine progress(!line.quiet);
  if (progress.shown()) progress.show("measuring");
  std::string title;
  choose_output_directory(&line, "psd");
  const RunOptions options = run_options(line, &progress);
  ResultFolder::look(options.output_directory, claim_of_psd(options));  // before there is anything to lose
  std::shared_ptr<const Study> study;
  const MeasuredPsd measured = measured_by(line, &title, &study);
  const Answer found = answer_psd(measured, title, options, study.get());
  progress.clear();
  return show(line, found, true);
}

}  // namespace aberfit
