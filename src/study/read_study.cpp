#include "aberfit/study/read_study.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/study/measured_psd.h"
#include "aberfit/study/parse_json.h"
#include "aberfit/study/unusual.h"
#include "describe.h"
#include "load_files.h"
#include "study_changes.h"
#include "study_of_json.h"
#include "study_rules.h"

namespace aberfit {
using namespace internal;

namespace {

struct NodeOfModel {
  template <typename Closed>
  RoughnessModel operator()(const Closed& model) const {
    return {model};
  }
  RoughnessModel operator()(const TablePsd&) const {
    throw std::invalid_argument("a table has no closed form");
  }
  RoughnessModel operator()(const SumPsd& sum) const {
    RoughnessSum result;
    for (const PsdModel& part : sum.parts) result.parts.push_back(roughness_model(part));
    return {result};
  }
};

struct ModelOfNode {
  template <typename Closed>
  PsdModel operator()(const Closed& model) const {
    return model;
  }
  PsdModel operator()(const PsdTableFile& table) const { return table.table.psd; }
  PsdModel operator()(const MeasuredPsd& measured) const { return measured.result.model; }
  PsdModel operator()(const RoughnessSum& sum) const {
    SumPsd result;
    for (const RoughnessModel& part : sum.parts) result.parts.push_back(psd_model(part));
    return result;
  }
};

// Returns whether every part has a closed form: a study cannot express a table without a file.
bool has_closed_form(const PsdModel& model) {
  const auto* sum = std::get_if<SumPsd>(&model);
  return sum ? std::all_of(sum->parts.begin(), sum->parts.end(), has_closed_form)
             : !std::holds_alternative<TablePsd>(model);
}

// Fills in what follows from other members, without reading any file.
void fill_in(Study* study) {
  Mirror& mirror = study->mirror;
  if (!mirror.zernike.empty() && mirror.zernike_radius == 0)
    mirror.zernike_radius = aperture_radius(study->aperture);
  if (study->psd && !study->roughness && has_closed_form(*study->psd))
    study->roughness = roughness_model(*study->psd);
}

MeasuredPsd* first_measured(RoughnessModel* node) {
  if (auto* measured = std::get_if<MeasuredPsd>(&node->model)) return measured;
  if (auto* sum = std::get_if<RoughnessSum>(&node->model))
    for (RoughnessModel& part : sum->parts)
      if (MeasuredPsd* measured = first_measured(&part)) return measured;
  return nullptr;
}

void put_in_place(const StudyData& data, Study* study) {
  MeasuredPsd* const measured = study->roughness ? first_measured(&*study->roughness) : nullptr;
  const auto refuse = [&](const char* what, const char* place) {
    throw InputError(study->path, "", std::string("a ") + what + " that the study has no place for", place);
  };
  if (data.map && study->map) study->map->source.values = data.map;
  const bool is_same = study->map && measured && measured->source.file == study->map->source.file;
  if (data.map && measured && (is_same || !study->map)) measured->source.values = data.map;
  if (data.map && !measured && !study->map)
    refuse("map", "a block target.map, or a psd of model \"measured\"; both with a name as `file`");
  if (data.profile && !measured) refuse("profile", "a psd of model \"measured\" with a name as `file`");
  if (data.profile) measured->source.values = data.profile;
  if (!data.mask) return;
  auto* const mask = study->obstructed ? std::get_if<MaskFile>(&study->obstructed->shape) : nullptr;
  if (!mask) refuse("mask", "an aperture of shape \"mask\" with a name as `file`");
  mask->values = data.mask;
}

}  // namespace

Study internal::study_of_json(const nlohmann::ordered_json& json, const std::string& path,
                              const std::vector<std::string>& changes, const Study* same_roughness,
                              const StudyData& data) {
  Study study;
  study.path = path;
  study.changes = changes;
  study.typed = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  try {
    read_object(json, study.path, [&](Visitor& v) { describe_study(v, study); });
    put_in_place(data, &study);
    if (same_roughness) {
      study.roughness = same_roughness->roughness;
      study.psd = same_roughness->psd;
    }
    study = completed(std::move(study));
  } catch (const InputError& error) {
    if (error.file() != path) throw;
    throw InputError(file_with_changes(path, changes, error.pointer()), error.pointer(), error.found(),
                     error.allowed());
  }
  return study;
}

Study parse_study(const std::string& text, const std::string& path, const std::vector<std::string>& changes,
                  const StudyData& data) {
  nlohmann::ordered_json json = parse_json(text, path);
  apply_changes(changes, &json);
  return study_of_json(json, path, changes, nullptr, data);
}

std::string internal::text_of_study(const std::string& path) {
  // Some terminals write UTF-16 if output is redirected to a file.
  const auto whole = [](std::istream& in) {
    return utf8_text(std::string{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()});
  };
  if (path == "-") return whole(std::cin);
  std::error_code error;
  std::ifstream file(path, std::ios::binary);
  if (!file || !std::filesystem::is_regular_file(path, error))
    throw InputError(path, "", "a file that cannot be read", "a study file (JSON)");
  return whole(file);
}

Study read_study(const std::string& path, const std::vector<std::string>& changes, const StudyData& data) {
  return parse_study(text_of_study(path), path == "-" ? kStandardInput : path, changes, data);
}

MeasuredPsd read_measured(const nlohmann::ordered_json& block, const std::string& source, int threads) {
  MeasuredPsd measured;
  read_object(block, source, [&](Visitor& v) { describe_measured_psd(v, measured); });
  measure_psd(measured, "", source, "", threads);
  return measured;
}

nlohmann::ordered_json psd_block(const RoughnessModel& roughness) {
  RoughnessModel copy = roughness;
  return write_object([&](Visitor& v) { describe_psd_block(v, copy); });
}

RoughnessModel roughness_model(const PsdModel& model) { return std::visit(NodeOfModel{}, model); }

Study completed(Study study) {
  if (study.path.empty()) study.path = "study";
  study.data_warnings.clear();
  load_files(study);
  fill_in(&study);
  check_rules(study);
  const Warnings unusual = unusual_warnings(study);
  study.data_warnings.insert(study.data_warnings.end(), unusual.begin(), unusual.end());
  return study;
}

nlohmann::ordered_json resolved_study(const Study& study) {
  Study copy = study;  // visitors take references that they may write to
  fill_in(&copy);
  return write_object([&](Visitor& v) { describe_study(v, copy); });
}

nlohmann::ordered_json resolved_study(const Study& study, const ChosenByFit& chosen) {
  Study explicit_study = study;
  explicit_study.terms = chosen.terms;
  explicit_study.trace.pupil.rays = chosen.rays;
  explicit_study.fit.starts = chosen.starts;
  return resolved_study(explicit_study);
}

bool names_file(const std::string& key) { return key == "file" || key == "mask"; }

nlohmann::ordered_json study_schema() {
  Study study;
  nlohmann::ordered_json definitions = nlohmann::ordered_json::object();
  nlohmann::ordered_json root = object_schema([&](Visitor& v) { describe_study(v, study); }, &definitions);
  nlohmann::ordered_json schema;
  schema["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  schema["$id"] = "aberfit.schema.json";  // a study beside the file has "$schema": "./aberfit.schema.json"
  schema["title"] = "aberfit study, format version 1";
  schema["description"] =
      "Quantities are strings with a unit (\"632.8 nm\") or plain numbers in SI units. Paths are relative to "
      "the study file. The roughness is needed unless every statistic has a value.";
  schema.update(root);
  schema["$defs"] = std::move(definitions);
  return schema;
}

Contributors contributors(const ContributorsSpec& with) {
  Contributors result;
  for (const OtherSurfaceSpec& surface : with.surfaces)
    result.surfaces.push_back(
        {surface.name, psd_model(surface.psd), surface.footprint, surface.incidence, surface.is_wavefront});
  result.atmosphere = with.atmosphere;
  result.jitter = with.jitter;
  return result;
}

PsdModel psd_model(const RoughnessModel& roughness) { return std::visit(ModelOfNode{}, roughness.model); }

}  // namespace aberfit
