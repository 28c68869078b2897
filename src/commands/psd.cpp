#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/report/psd_report.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/measured_psd.h"
#include "aberfit/study/read_study.h"
#include "output_directory.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

namespace {

using nlohmann::ordered_json;

// The first measurement of a psd block; null when there is none.
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

// A number where the whole text is one, so that plain SI numbers do as in a study.
ordered_json option_value(const std::string& text) {
  std::int64_t whole = 0;
  double number = 0;
  const char *begin = text.data() + (text.starts_with('+') ? 1 : 0), *end = text.data() + text.size();
  if (const auto [at, error] = std::from_chars(begin, end, whole); error == std::errc{} && at == end)
    return whole;
  if (const auto [at, error] = std::from_chars(begin, end, number); error == std::errc{} && at == end)
    return number;
  return text;
}

// "annulus:outer=95%,inner=30%,centre=1mm,0mm" as the object of a study.
ordered_json aperture_object(const std::string& text) {
  static const std::map<std::string, std::string> kShort = {
      {"outer", "diameter"}, {"inner", "inner_diameter"}, {"center", "centre"}};
  const std::size_t colon = std::min(text.find(':'), text.size());
  ordered_json object = {{"shape", text.substr(0, colon)}};
  std::string key;
  const auto refuse = [&](const std::string& allowed) {
    throw InputError(kCommandLine, "", "--aperture \"" + text + "\"", allowed);
  };
  for (const std::string_view piece : words(std::string_view(text).substr(colon), ":,")) {
    const std::size_t equals = piece.find('=');
    if (equals != std::string_view::npos) {
      key = trimmed(piece.substr(0, equals));
      if (kShort.contains(key)) key = kShort.at(key);
      if (object.contains(key)) refuse("every key once, \"" + key + "\" is there twice");
    }
    // A comma of a number, 1,5mm, would begin a second value.
    if (key.empty() || (equals == std::string_view::npos && key != "centre"))
      refuse(
          "SHAPE:key=value,..., e.g. \"circle:diameter=95%\", with a point in numbers; only centre has two "
          "values");
    const ordered_json value = option_value(
        std::string(trimmed(equals == std::string_view::npos ? piece : piece.substr(equals + 1))));
    if (key == "centre")
      object[key].push_back(value);
    else
      object[key] = value;
  }
  return object;
}

// "low=0.1/mm..1/mm,mid=1/mm..10/mm" as the list that a study has.
ordered_json bands_of(const std::string& text) {
  ordered_json bands = ordered_json::array();
  for (const std::string_view band : words(text, ",")) {
    const std::size_t equals = band.find('='), dots = band.find("..");
    if (equals == std::string_view::npos || dots == std::string_view::npos || dots < equals)
      throw InputError(kCommandLine, "option --bands", in_quotes(band),
                       "NAME=FREQ..FREQ, separated by commas, such as low=0.1/mm..1/mm,mid=1/mm..10/mm");
    const auto part = [&](std::size_t from, std::size_t to) {
      return std::string(trimmed(band.substr(from, to - from)));
    };
    bands.push_back({{"name", part(0, equals)},
                     {"f_min", option_value(part(equals + 1, dots))},
                     {"f_max", option_value(part(dots + 2, band.size()))}});
  }
  return bands;
}

// What is measured: a study's measurement, or files with the options of the command line.
MeasuredPsd measured_by(const CommandLine& line, std::string* title) {
  const std::string& first = line.measured_files.front();
  if (std::filesystem::path(first).extension() == ".json") {
    if (line.measured_files.size() > 1 || !line.psd_of_file.empty() || !line.psd_of_block.empty() ||
        line.keep_lines)
      throw InputError("command line", "", "options or further files beside a study",
                       "the study alone: they are keys of its `psd` block");
    const Study study = read_study(first);
    *title = study.title;
    return measured_psd_of(study);
  }
  ordered_json source = ordered_json::object(), block;
  for (const auto& [key, text] : line.psd_of_file)
    source[key] = key == "aperture" ? aperture_object(text) : option_value(text);
  for (const auto& [key, text] : line.psd_of_block)
    block[key] = key == "bands" ? bands_of(text) : option_value(text);
  for (const std::string& file : line.measured_files) {
    source["file"] = file;
    if (&file == &first)
      block.update(source);
    else
      block["further"].push_back(source);
  }
  if (line.keep_lines) block["find_lines"] = false;
  *title = std::filesystem::path(first).filename().string();
  return read_measured(block, kCommandLine, line.threads);
}

}  // namespace

const MeasuredPsd& measured_psd_of(const Study& study) {
  const MeasuredPsd* measured = study.roughness ? find_measured(*study.roughness) : nullptr;
  if (!measured)
    throw InputError(study.path, "/roughness/psd", "no measurement in the roughness",
                     "a psd of model \"measured\"; or give `aberfit psd` the measured file itself");
  return *measured;
}

PsdReport run_psd(const MeasuredPsd& measured, const std::string& title, const RunOptions& options) {
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
  report.provenance = make_provenance(0, context_of(options).threads);
  ResultFolder results(options.output_directory);
  if (results.wanted()) {
    const std::string folder = results.path() + "/";
    if (options.plots) write_psd_plots(report, folder, &report.warnings);
    const ordered_json roughness = roughness_block(measured);
    write_file(folder + "psd.csv", psd_csv(report));
    write_file(folder + "bands.csv", bands_csv(report));
    write_file(folder + "roughness.json", roughness.dump(2) + "\n");
    write_file(folder + "summary.txt", summary_table(report, roughness));
    write_file(folder + "result.json", psd_json(report, measured).dump(2) + "\n");
    results.show();
  }
  return report;
}

ExitCode psd_command(CommandLine line) {
  line.study_file = line.measured_files.front();
  ProgressLine progress(!line.quiet);
  if (progress.shown()) progress.show("measuring");
  std::string title;
  const MeasuredPsd measured = measured_by(line, &title);
  choose_output_directory(&line);
  const PsdReport report = run_psd(measured, title, run_options(line, &progress));
  progress.clear();
  print(line, psd_json(report, measured), summary_table(report, roughness_block(measured)));
  say_where(line);
  return measured.result.status == PsdFitStatus::kConverged ? ExitCode::kDone : ExitCode::kNotMet;
}

}  // namespace aberfit
