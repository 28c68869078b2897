#include "aberfit/study/study_cases.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>

#include "aberfit/core/content_hash.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/study/parse_json.h"
#include "aberfit/study/read_study.h"
#include "study_changes.h"
#include "study_of_json.h"

namespace aberfit {
using namespace internal;

namespace {

using Json = nlohmann::ordered_json;

// Returns whether this value, set at `pointer`, may name a file.
bool may_name_file(const std::string& pointer, const std::string& value) {
  return names_file(pointer.substr(pointer.rfind('/') + 1)) || value.find("\"file\"") != std::string::npos ||
         value.find("\"mask\"") != std::string::npos;
}

bool is_below(const std::string& pointer, const std::string& block) {
  return pointer == block || pointer.starts_with(block + "/");
}

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): the constructor of a study may throw
struct StudyCases::Content {
  Json json;  // what cases begin from
  Study study;
  bool roughness_varies = false;
  std::string base;
  mutable std::mutex mutex;
  mutable std::map<std::string, std::string> hash_of_file;

  // Only the content of a file counts, not its path.
  void replace_files(nlohmann::json* node) const {
    if (!node->is_structured()) return;
    for (auto item = node->begin(); item != node->end(); ++item) {
      if (node->is_object() && names_file(item.key()) && item->is_string())
        *item = hash_of(item->get<std::string>());
      replace_files(&*item);
    }
  }
  std::string hash_of(const std::string& file) const {
    const std::string path = (std::filesystem::path(study.path).parent_path() / file).string();
    const std::lock_guard lock(mutex);
    const auto known = hash_of_file.find(path);
    if (known != hash_of_file.end()) return known->second;
    const std::optional<std::string> bytes = file_bytes(path);
    return hash_of_file[path] = bytes ? "content " + content_hash(*bytes) : file;
  }
  std::string hash_of(const Json& resolved) const {
    nlohmann::json sorted = resolved;
    for (const char* block : {"title", "description", "$schema", "vary", "verify", "output"})
      sorted.erase(block);
    if (study.vary->run != CaseLevel::kSolve) sorted.erase("solve");
    replace_files(&sorted);
    return content_hash(to_string(study.vary->run) + "\n" +
                        sorted.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  }
  Json with(const CaseValues& values) const {
    Json changed = json;
    for (const auto& [pointer, value] : values) {
      try {
        apply_changes({pointer + "=" + value}, &changed);
      } catch (const InputError& error) {  // it names an option
        throw InputError(study.path, child_pointer("/vary/over", pointer), error.found(),
                         "a pointer that leads through objects and arrays of the study");
      }
    }
    return changed;
  }
};

StudyCases::StudyCases(const std::string& text, const std::string& path,
                       const std::vector<std::string>& changes)
    : content_(std::make_unique<Content>()) {
  Content& own = *content_;
  own.json = parse_json(text, path);
  apply_changes(changes, &own.json);
  own.study = study_of_json(own.json, path, changes, nullptr);
  if (!own.study.vary)
    throw InputError(path, "/vary", kMissing,
                     "`aberfit sweep` needs a block such as \"vary\": {\"over\": {\"/roughness/psd/rms\": "
                     "[\"10 nm\", \"20 nm\"]}}; `aberfit new sweep` writes such a study");
  for (const char* unused : {"vary", "verify", "output"}) own.json.erase(unused);
  bool file_varies = false;
  for (const VaryAxis& axis : own.study.vary->axes) {
    own.roughness_varies = own.roughness_varies || is_below(axis.pointer, "/roughness");
    for (const std::string& value : axis.values)
      file_varies = file_varies || may_name_file(axis.pointer, value);
  }
  if (!file_varies) own.base = own.hash_of(own.json);
}

StudyCases StudyCases::read(const std::string& path, const std::vector<std::string>& changes) {
  return {text_of_study(path), path == "-" ? kStandardInput : path, changes};
}

StudyCases::~StudyCases() = default;
StudyCases::StudyCases(StudyCases&&) noexcept = default;

const Study& StudyCases::study() const { return content_->study; }
const std::string& StudyCases::base() const { return content_->base; }

Study StudyCases::at(const CaseValues& values) const {
  const Content& own = *content_;
  return study_of_json(own.with(values), own.study.path, own.study.changes,
                       own.roughness_varies ? nullptr : &own.study);
}

std::string StudyCases::id(const Study& of_case) const { return content_->hash_of(resolved_study(of_case)); }

std::string StudyCases::id_of_unreadable(const CaseValues& values) const {
  return content_->hash_of(content_->with(values));
}

}  // namespace aberfit
