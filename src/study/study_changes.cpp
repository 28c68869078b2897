#include "study_changes.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "aberfit/core/errors.h"
#include "aberfit/study/parse_json.h"

namespace aberfit::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kChangeForm =
    "/json/pointer=value, a key of the study and its new value, e.g. --set \"/roughness/psd/rms=60 nm\"";

[[noreturn]] void refuse_change(const std::string& change, const std::string& found,
                                const std::string& allowed) {
  throw InputError("command line", "--set \"" + change + "\"", found, allowed);
}

struct Change {
  std::string pointer, value;
};

Change split_change(const std::string& change) {
  const std::size_t equals = change.find('=');
  if (equals == std::string::npos) refuse_change(change, "no value", kChangeForm);
  if (change.front() != '/') refuse_change(change, "not a JSON pointer, which begins with /", kChangeForm);
  return {change.substr(0, equals), change.substr(equals + 1)};
}

// The keys of a JSON pointer (RFC 6901), in which ~1 stands for a slash and ~0 for a tilde.
std::vector<std::string> keys_of_pointer(const Change& change, const std::string& typed) {
  std::vector<std::string> keys;
  for (std::size_t at = 1;;) {
    const std::size_t end = std::min(change.pointer.find('/', at), change.pointer.size());
    std::string key;
    for (std::size_t i = at; i < end; ++i) {
      const char c = change.pointer[i];
      if (c != '~') {
        key += c;
        continue;
      }
      const char next = i + 1 < end ? change.pointer[++i] : ' ';
      if (next != '0' && next != '1') refuse_change(typed, "a ~ alone", "~0 for ~ and ~1 for / in a key");
      key += next == '0' ? '~' : '/';
    }
    keys.push_back(key);
    if (end == change.pointer.size()) return keys;
    at = end + 1;
  }
}

std::optional<std::size_t> index_of(const std::string& key, std::size_t size) {
  constexpr std::size_t kMostDigits = 6;
  const bool digits = !key.empty() && key.size() <= kMostDigits &&
                      std::all_of(key.begin(), key.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (key == "-") return size;
  if (!digits || (key.size() > 1 && key.front() == '0') || std::stoul(key) > size) return std::nullopt;
  return std::stoul(key);
}

void apply_change(const std::string& typed, Json* json) {
  const Change change = split_change(typed);
  Json* here = json;
  std::string way;
  for (const std::string& key : keys_of_pointer(change, typed)) {
    if (here->is_null()) *here = Json::object();
    if (here->is_array()) {
      const std::optional<std::size_t> index = index_of(key, here->size());
      if (!index)
        refuse_change(typed, fmt::format("\"{}\" in the array {}", key, way),
                      fmt::format("an index from 0 to {}, which appends", here->size()));
      if (*index == here->size()) here->push_back(nullptr);
      here = &(*here)[*index];
    } else if (here->is_object()) {
      here = &(*here)[key];
    } else {
      refuse_change(typed, fmt::format("{} at {}, which has no keys", here->dump(), way),
                    fmt::format("an object; create it first, e.g. --set \"{}={{}}\"", way));
    }
    way = child_pointer(way, key);
  }
  *here =
      Json::accept(change.value) ? parse_json(change.value, "--set \"" + typed + "\"") : Json(change.value);
}

}  // namespace

void apply_changes(const std::vector<std::string>& changes, Json* json) {
  for (const std::string& change : changes) apply_change(change, json);
}

std::string file_with_changes(const std::string& file, const std::vector<std::string>& changes,
                              const std::string& pointer) {
  const auto leads_to = [](const std::string& from, const std::string& to) {
    return to.starts_with(from) && (to.size() == from.size() || to[from.size()] == '/');
  };
  std::string text = file;
  for (const std::string& change : changes) {
    const std::string changed = change.substr(0, change.find('='));
    const std::string parent = changed.substr(0, changed.rfind('/'));
    const bool beside = !parent.empty() && pointer.substr(0, pointer.rfind('/')) == parent;
    if (leads_to(changed, pointer) || leads_to(pointer, changed) || beside)
      text += fmt::format(" with --set \"{}\"", change);
  }
  return text;
}

}  // namespace aberfit::internal
