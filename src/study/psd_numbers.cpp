#include "aberfit/study/psd_numbers.h"

#include <map>
#include <nlohmann/json.hpp>

#include "aberfit/core/constants.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

using Json = nlohmann::ordered_json;

Dimension dimension_of(PsdRole role) {
  if (role == PsdRole::kExponent) return Dimension::kNumber;
  if (role == PsdRole::kAmplitude || role == PsdRole::kDensity) return Dimension::kPsd2d;
  return role == PsdRole::kRms || role == PsdRole::kLength ? Dimension::kLength
                                                           : Dimension::kSpatialFrequency;
}

// Keys of all models, and the scale of tables.
template <class... Models>
std::map<std::string, Dimension> dimensions_of(const std::variant<Models...>&) {
  std::map<std::string, Dimension> dimensions = {{"scale", Dimension::kNumber}};
  for (PsdModel model : {PsdModel(Models{})...})
    for (const PsdMember& member : psd_members(model)) dimensions[member.key] = dimension_of(member.role);
  return dimensions;
}

void collect(const Json& psd, const std::string& pointer, std::vector<PsdNumber>* numbers) {
  static const std::map<std::string, Dimension> kDimensions = dimensions_of(PsdModel());
  if (psd.value("model", "") == "measured") return;
  for (const auto& [key, dimension] : kDimensions)
    if (psd.contains(key) && psd[key].is_number())
      numbers->push_back({pointer + "/" + key, psd[key].get<double>(), dimension});
  // A resolved k-correlation has B, but a study with the length may ask for the length.
  if (psd.value("model", "") == "k-correlation" && psd.contains("B"))
    numbers->push_back(
        {pointer + "/correlation_length", psd["B"].get<double>() / (2 * kPi), Dimension::kLength});
  if (!psd.contains("parts")) return;
  for (std::size_t i = 0; i < psd["parts"].size(); ++i)
    collect(psd["parts"][i], pointer + "/parts/" + std::to_string(i), numbers);
}

}  // namespace

std::vector<PsdNumber> psd_numbers(const Study& study) {
  std::vector<PsdNumber> numbers;
  const Json resolved = resolved_study(study);
  if (resolved.contains("roughness")) collect(resolved["roughness"]["psd"], "/roughness/psd", &numbers);
  return numbers;
}

struct StudyFamily::Text {
  std::string path;
  Json study;
  std::vector<Json::json_pointer> pointers;
};

StudyFamily::StudyFamily(const Study& study, const std::vector<std::string>& pointers) {
  Text text{study.path, resolved_study(study), {}};
  for (const char* unused : {"verify", "vary", "output"}) text.study.erase(unused);
  // We keep the budgets, because a study with budgets needs no height variance. We drop parts that would be
  // read from files.
  if (text.study.contains("solve")) {
    if (text.study["solve"].contains("so_that"))
      text.study["solve"].erase("with");
    else
      text.study.erase("solve");
  }
  for (const std::string& pointer : pointers) {
    text.pointers.emplace_back(pointer);
    const Json::json_pointer &number = text.pointers.back(), around = number.parent_pointer();
    // The length takes the place of B.
    if (number.back() == "correlation_length" && text.study.contains(around / "B"))
      text.study[around].erase("B");
  }
  text_ = std::make_shared<const Text>(std::move(text));
}

StudyFamily::~StudyFamily() = default;

Task StudyFamily::operator()(const std::vector<double>& values) const {
  Json study = text_->study;
  for (std::size_t k = 0; k < values.size(); ++k) study[text_->pointers[k]] = values[k];
  return parse_study(study.dump(), text_->path);
}

}  // namespace aberfit
