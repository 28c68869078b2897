#include <filesystem>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/report/psd_report.h"
#include "aberfit/study/read_study.h"
#include "aberfit/commands/run.h"

namespace aberfit {
namespace {

// The first measurement of a psd block; null when there is none.
const MeasuredPsd* find_measured(const RoughnessModel& node) {
  if (const auto* measured = std::get_if<MeasuredPsd>(&node.model)) return measured;
  if (const auto* sum = std::get_if<RoughnessSum>(&node.model))
    for (const RoughnessModel& part : sum->parts)
      if (const MeasuredPsd* measured = find_measured(part)) return measured;
  return nullptr;
}

}  // namespace

const MeasuredPsd& measured_psd_of(const Study& study) {
  const MeasuredPsd* measured = study.roughness ? find_measured(*study.roughness) : nullptr;
  if (!measured)
    throw InputError(study.path, "/roughness/psd", "no measurement in the roughness",
                     "a psd of model \"measured\"; or give `aberfit psd` the measured file itself");
  return *measured;
}

nlohmann::ordered_json run_psd(const MeasuredPsd& measured, const std::string& title,
                               const RunOptions& options, std::string* table) {
  PsdReport report;
  report.title = title;
  report.files.push_back(measured.source.file);
  for (const MeasuredFile& file : measured.further) report.files.push_back(file.file);
  report.data = measured.data;
  report.estimate = measured.estimate;
  report.fit = measured.result;
  report.request = psd_block(RoughnessModel{measured});
  report.roughness = {{"psd", psd_block(roughness_model(measured.result.model))}};
  report.warnings = measured.estimate.warnings;
  report.warnings.insert(report.warnings.end(), measured.result.warnings.begin(),
                         measured.result.warnings.end());
  report.provenance = make_provenance(0, options.threads > 0 ? options.threads : available_threads());
  if (!options.output_directory.empty()) {
    if (options.plots) write_psd_plots(report, options.output_directory, &report.warnings);
    const std::string folder = options.output_directory + "/";
    write_file(folder + "psd.csv", psd_csv(report));
    write_file(folder + "roughness.json", report.roughness.dump(2) + "\n");
    write_file(folder + "summary.txt", summary_table(report));
    write_file(folder + "result.json", to_json(report).dump(2) + "\n");
  }
  if (table) *table = summary_table(report);
  return to_json(report);
}

}  // namespace aberfit
