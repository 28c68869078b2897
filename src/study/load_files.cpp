#include "load_files.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <string_view>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/text.h"
#include "aberfit/measured/clear_aperture.h"
#include "aberfit/study/measured_psd.h"
#include "clear_of.h"
#include "statistic_key.h"

namespace aberfit::internal {
namespace {

// Path of a data file, relative to the study's folder. Throws unless it is a readable file.
std::string locate(const Study& study, const std::string& file, const std::string& pointer) {
  const std::filesystem::path path = std::filesystem::path(study.path).parent_path() / file;
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error) || !std::ifstream(path))
    throw InputError(study.path, pointer, fmt::format("\"{}\", which is not a readable file", file),
                     "a file, relative to the folder of the study");
  return path.string();
}

void load_roughness(const Study& study, RoughnessModel& node, const std::string& pointer) {
  if (auto* sum = std::get_if<RoughnessSum>(&node.model)) {
    for (std::size_t i = 0; i < sum->parts.size(); ++i)
      load_roughness(study, sum->parts[i], fmt::format("{}/parts/{}", pointer, i));
  }
  if (auto* measured = std::get_if<MeasuredPsd>(&node.model); measured && measured->data.empty()) {
    if (!measured->source.values) locate(study, measured->source.file, pointer + "/file");
    for (std::size_t i = 0; i < measured->further.size(); ++i)
      locate(study, measured->further[i].file, fmt::format("{}/further/{}/file", pointer, i));
    measure_psd(*measured, std::filesystem::path(study.path).parent_path().string(), study.path, pointer,
                available_threads());
  }
  auto* table = std::get_if<PsdTableFile>(&node.model);
  if (!table || !table->table.psd.frequency.empty()) return;
  PsdTableOptions options;
  const bool profile = table->kind == "1d";
  if (!table->frequency_unit.empty())
    options.frequency_factor = unit_factor(table->frequency_unit, Dimension::kSpatialFrequency);
  if (!table->psd_unit.empty())
    options.psd_factor = unit_factor(table->psd_unit, profile ? Dimension::kPsd1d : Dimension::kPsd2d);
  options.kind = profile ? PsdTableKind::k1dOneSided : PsdTableKind::k2dTwoSided;
  options.of = table->of == "wavefront" ? PsdTableOf::kWavefront : PsdTableOf::kSurface;
  options.height_factor = table->scale;
  options.f_min = table->f_min;
  options.f_max = table->f_max;
  const std::string path = locate(study, table->file, pointer + "/file");
  try {
    table->table = read_psd_table(path, options);
  } catch (const InputError& error) {
    throw InputError(study.path, pointer + "/file", fmt::format("in \"{}\": {}", table->file, error.found()),
                     error.allowed());
  }
}

SegmentedAperture outlines_of(const Study& study, const MaskFile& mask) {
  const std::string path = mask.values ? "" : locate(study, mask.file, "/aperture/file");
  try {
    return mask_outlines(mask.values ? *mask.values : read_mask(path), mask.pitch);
  } catch (const ComputationError& error) {
    throw InputError(study.path, "/aperture/file", fmt::format("in \"{}\": {}", mask.file, error.what()),
                     "an image from 0 (opaque) to 1 (clear) that is grey only at edges");
  }
}

// A file leaves only masks to us, a program also shapes with spiders.
void load_aperture(Study* study) {
  if (aperture_area(study->aperture) > 0) return;
  const ApertureSpec& spec = *study->obstructed;
  const auto* mask = std::get_if<MaskFile>(&spec.shape);
  const std::optional<Aperture> clear =
      clear_of(spec, mask ? outlines_of(*study, *mask) : SegmentedAperture{});
  if (!clear)
    throw InputError(study->path, "/aperture/spiders", "vanes that cover the aperture",
                     "vanes that leave a part of it clear");
  study->aperture = *clear;
}

// '#' after a blank starts a comment; one row of names may stand before the numbers.
void load_profile(const Study& study, StatisticRequest& request, const std::string& pointer) {
  const char* const allowed =
      "two columns, at least 2 rows: ascending dz (in m unless the header says \"dz_mm\" or similar) and "
      "energy fraction from 0 to 1";
  TextLines file(locate(study, request.file, pointer));
  std::string_view line;
  const auto fail = [&] {
    throw InputError(
        study.path, pointer,
        fmt::format("in \"{}\", line {}: \"{}\"", request.file, file.number(), line.substr(0, 60)), allowed);
  };
  request.profile_dz.clear();
  request.profile_value.clear();
  bool header_seen = false;
  double metres = 1;  // in one unit of dz
  while (file.next(&line)) {
    const std::string_view numbers = before_comment(line);
    const std::vector<std::string_view> cells = words(numbers, " \t\r,;\"");
    if (cells.empty()) continue;
    if (const auto comma = decimal_comma(numbers))
      throw InputError(study.path, pointer,
                       fmt::format("in \"{}\", line {}: {}, a decimal comma", request.file, file.number(),
                                   in_quotes(*comma)),
                       kDecimalPoint);
    const std::optional<double> dz = parse_finite(cells[0]);
    const std::optional<double> share = cells.size() == 2 ? parse_finite(cells[1]) : std::nullopt;
    if (!dz && !header_seen && request.profile_dz.empty()) {
      header_seen = true;
      const std::string_view name = numbers.substr(0, numbers.find_first_of(",;\t"));
      if (const std::string unit = unit_of_column(name, Dimension::kLength); !unit.empty())
        metres = unit_factor(unit, Dimension::kLength);
      continue;
    }
    if (!dz || !share || !(*share >= 0 && *share <= 1)) fail();
    if (!request.profile_dz.empty() && !(*dz * metres > request.profile_dz.back())) fail();
    request.profile_dz.push_back(*dz * metres);
    request.profile_value.push_back(*share);
  }
  if (request.profile_dz.size() < 2)
    throw InputError(study.path, pointer,
                     fmt::format("in \"{}\": {} rows", request.file, request.profile_dz.size()), allowed);
}

bool is_loaded(const FocusSpec& focus) {
  const auto* curve = std::get_if<EncircledCurve>(&focus.measured.data);
  return !curve || curve->radius.size() > 0;
}

// Errors in a curve or an image already name its file and line.
void load_focus(FocusSpec* focus, const std::string& path) {
  if (focus->kind == "image" || (focus->kind == "auto" && is_focal_image(path)))
    focus->measured.data = read_focal_image(path);
  else
    focus->measured.data = read_encircled_curve(path, focus->radius_unit);
}

constexpr double kNoticedShare = 1e-3;  // fraction of a variance; we warn if more is left out

// Warns of what was left out of the tables of the specification, and repeats the warnings of its
// measurements.
void warn_of_data(const RoughnessModel& node, Warnings* warnings) {
  if (const auto* sum = std::get_if<RoughnessSum>(&node.model))
    for (const RoughnessModel& part : sum->parts) warn_of_data(part, warnings);
  if (const auto* measured = std::get_if<MeasuredPsd>(&node.model)) {
    for (const Warnings* told : {&measured->estimate.warnings, &measured->result.warnings})
      warnings->insert(warnings->end(), told->begin(), told->end());
  }
  const auto* file = std::get_if<PsdTableFile>(&node.model);
  if (!file) return;
  const PsdTableResult& table = file->table;
  if (table.variance_left_out > kNoticedShare || table.slope_variance_left_out > kNoticedShare)
    warnings->push_back(
        {"band-cut",
         fmt::format("the band {:.4g} to {:.4g} /m of \"{}\" leaves out {:.1f} % of the table's height "
                     "variance and {:.1f} % of its slope variance; slopes determine the focus by rays",
                     table.psd.frequency.front(), table.psd.frequency.back(), file->file,
                     100 * table.variance_left_out, 100 * table.slope_variance_left_out)});
  if (table.not_positive > 0)
    warnings->push_back(
        {"psd-points-left-out",
         fmt::format("{} point{} of \"{}\" left out: the profile PSD rises there and has no isotropic "
                     "two-dimensional counterpart",
                     table.not_positive, table.not_positive == 1 ? "" : "s", file->file)});
}

}  // namespace

void load_files(Study& study) {
  if (study.obstructed) load_aperture(&study);
  if (study.roughness && !study.psd) {
    load_roughness(study, *study.roughness, "/roughness/psd");
    study.psd = psd_model(*study.roughness);
  }
  if (study.roughness) warn_of_data(*study.roughness, &study.data_warnings);
  if (study.solve && study.solve->with)
    for (std::size_t k = 0; k < study.solve->with->surfaces.size(); ++k)
      load_roughness(study, study.solve->with->surfaces[k].psd,
                     fmt::format("/solve/with/surfaces/{}/psd", k));
  if (study.solve && study.solve->focus && !is_loaded(*study.solve->focus))
    load_focus(&*study.solve->focus, locate(study, study.solve->focus->file, "/solve/focus/file"));
  if (study.map && !study.map->source.values) locate(study, study.map->source.file, "/target/map/file");
  const std::vector<std::string> keys = keys_of(study.target.statistics);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    StatisticRequest& request = study.target.statistics[i];
    if (!request.file.empty() && request.profile_dz.empty())
      load_profile(study, request, "/target/statistics/" + keys[i] + "/file");
  }
}

}  // namespace aberfit::internal
