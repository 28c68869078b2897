#include "explain_schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "aberfit/commands/terminal_text.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"

namespace aberfit::internal {
namespace {

using Json = nlohmann::ordered_json;

// A key of the study and the schema's entry for it.
struct Place {
  std::string path;     // "target/statistics/ee50"; a sample if the key is data
  std::string pattern;  // regular expression of the last name if it is data, otherwise empty
  std::string kind;     // "circle": the alternative of the tagged object that has the key; may be empty
  bool required;
  const Json* schema;
};

class Places {
 public:
  explicit Places(const Json& schema) : root_(schema) { visit(schema, "", ""); }
  std::vector<Place> all;

  const Json& resolved(const Json& node) const {
    if (!node.contains("$ref")) return node;
    return root_.at(Json::json_pointer(node["$ref"].get<std::string>().substr(1)));
  }

 private:
  void visit(const Json& node, const std::string& path, const std::string& kind) {
    if (node.contains("$ref")) {
      const std::string name = node["$ref"];
      if (!open_.insert(name).second) return;  // a sum of PSDs has parts, which are PSDs
      visit(resolved(node), path, kind);
      open_.erase(name);
      return;
    }
    if (node.contains("oneOf"))
      for (const Json& one : node["oneOf"]) visit(one, path, tag_of(one));
    if (node.contains("items")) visit(node["items"], path, kind);
    const Json none = Json::array();
    const Json& required = node.contains("required") ? node["required"] : none;
    const std::string before = path.empty() ? "" : path + "/";
    if (node.contains("properties"))
      for (const auto& item : node["properties"].items())
        add({before + item.key(), "", kind,
             std::find(required.begin(), required.end(), item.key()) != required.end(), &item.value()});
    if (node.contains("patternProperties"))
      for (const auto& item : node["patternProperties"].items())
        add({before + item.value().value("title", item.key()), item.key(), kind, false, &item.value()});
  }
  // The alternatives of an object may have a key in common, such as spiders, whose own keys are listed once.
  bool is_known(const Place& place) const {
    return std::any_of(all.begin(), all.end(), [&](const Place& known) {
      return known.path == place.path && known.kind == place.kind && known.required == place.required &&
             *known.schema == *place.schema;
    });
  }
  void add(Place place) {
    if (is_known(place)) return;
    all.push_back(place);
    visit(*place.schema, place.path, "");
  }
  static std::string tag_of(const Json& alternative) {
    if (alternative.contains("properties"))
      for (const auto& item : alternative["properties"].items())
        if (item.value().contains("const") && item.value()["const"].is_string())
          return item.value()["const"].get<std::string>();
    return "";
  }

  const Json& root_;
  std::set<std::string> open_;
};

std::string name_of(const Place& place) { return place.path.substr(place.path.rfind('/') + 1); }

// Returns whether `key` names the place; with `alone`, its last names suffice.
bool is_called(const Place& place, const std::string& key, bool alone) {
  if (place.path == key || (alone && place.path.ends_with("/" + key))) return true;
  if (place.pattern.empty()) return false;
  const std::size_t cut = key.rfind('/') + 1;  // 0 if there is none
  const std::string before = place.path.substr(0, place.path.rfind('/') + 1);
  return (alone ? before.ends_with(key.substr(0, cut)) : before == key.substr(0, cut)) &&
         std::regex_match(key.substr(cut), std::regex(place.pattern));
}

struct Words {
  std::string meaning, units;
};
Words words_of(const Json& node) {
  const std::string text = node.value("description", "");
  static const std::string kUnits = ". Units: ";
  const std::size_t cut = text.find(kUnits);
  if (cut == std::string::npos) return {text, ""};
  return {text.substr(0, cut), text.substr(cut + kUnits.size(), text.size() - cut - kUnits.size() - 1)};
}

std::string type_of(const Json& node) {
  if (node.contains("$ref")) return "an object";
  if (node.contains("const")) return node["const"].dump();
  if (node.contains("enum")) return fmt::format("one of {}", fmt::join(node["enum"], ", "));
  for (const char* several : {"oneOf", "anyOf"}) {
    if (!node.contains(several)) continue;
    std::vector<std::string> types;
    for (const Json& one : node[several])
      if (const std::string type = type_of(one); std::find(types.begin(), types.end(), type) == types.end())
        types.push_back(type);
    return fmt::format("{}", fmt::join(types, ", or "));
  }
  if (!node.contains("type")) return "any value";
  const Json& type = node["type"];
  if (type.is_array()) {
    const bool quantity = std::find(type.begin(), type.end(), "string") != type.end();
    const std::string unit = node.contains("unit") ? " [" + node["unit"].get<std::string>() + "]" : "";
    return quantity ? "a quantity" : "a number" + unit + " or null";
  }
  if (type == "array") return "an array, each " + type_of(node["items"]);
  if (type == "boolean") return "true or false";
  if (type == "integer") return "a whole number";
  if (type != "string") return fmt::format("a{} {}", type == "object" ? "n" : "", type.get<std::string>());
  const std::string pattern = node.value("pattern", "");
  return pattern.starts_with("^") && pattern.find('\\') == std::string::npos
             ? "a word (" + pattern.substr(1, pattern.size() - 2) + ")"
             : "a text";
}

// Ends that only keep numbers within double precision do not help a reader, so we leave them out.
std::string range_of(const Json& node) {
  const auto end = [&](const char* key) {
    return node.contains(key) ? node[key].get<double>() : std::nan("");
  };
  constexpr double kTiny = 1e-15, kHuge = 1e12;
  std::vector<std::string> ends;
  if (const double low = end("minimum"); low > 0 && low <= kTiny)
    ends.emplace_back("above 0");
  else if (low > -kHuge)
    ends.push_back(fmt::format("at least {:g}", low));
  if (const double low = end("exclusiveMinimum"); low > -kHuge)
    ends.push_back(fmt::format("above {:g}", low));
  if (const double high = end("maximum"); high < kHuge) ends.push_back(fmt::format("at most {:g}", high));
  if (const double high = end("exclusiveMaximum"); high < kHuge)
    ends.push_back(fmt::format("below {:g}", high));
  return fmt::format("{}", fmt::join(ends, ", "));
}

std::string row_of(const Place& place) {
  const Json& node = *place.schema;
  std::string text = words_of(node).meaning;
  if (!text.empty()) text += "; ";
  text += type_of(node);
  if (const std::string range = range_of(node); !range.empty()) text += ", " + range;
  if (node.contains("default")) text += ", default " + node["default"].dump();
  if (node.contains("examples")) text += ", e.g. " + node["examples"][0].dump();
  return text;
}

// A table with names in one column and texts in the other.
std::string table(const std::vector<std::pair<std::string, std::string>>& rows, int width) {
  constexpr std::size_t kWidest = 20;
  std::size_t column = 0;
  for (const auto& row : rows) column = std::max(column, std::min(row.first.size(), kWidest));
  std::string text;
  for (const auto& [name, meaning] : rows) {
    const std::string head = fmt::format("  {:<{}}  ", name, column);
    const int indent = int(column) + 4;
    text += head + (name.size() > column ? "\n" + std::string(std::size_t(indent), ' ') : "");
    const std::string body = wrapped(std::string(std::size_t(indent), '.') + " " + meaning, width, indent);
    text += body.substr(std::size_t(indent) + 1) + "\n";
  }
  return text;
}

std::string keys_below(const Places& places, const Place* of, int width) {
  const std::string before = of ? of->path + "/" : "";
  std::string text, kind;
  std::vector<std::pair<std::string, std::string>> rows;
  const auto close = [&] {
    if (rows.empty()) return;
    const std::string with = kind.empty() ? "" : " of \"" + kind + "\"";
    text += fmt::format("\nkeys{} (* is required)\n", with) + table(rows, width);
    rows.clear();
  };
  for (const Place& place : places.all) {
    if (!place.path.starts_with(before) || place.path.find('/', before.size()) != std::string::npos) continue;
    if (place.kind != kind) close();
    kind = place.kind;
    rows.emplace_back((place.required ? "* " : "  ") + name_of(place), row_of(place));
  }
  close();
  return text;
}

bool is_alike(const Place& one, const Place& other) {
  return one.required == other.required && *one.schema == *other.schema;
}

// alike: one place, or a key that several alternatives of an object have in common.
std::string explained(const std::vector<const Place*>& alike, int width) {
  const Place& place = *alike.front();
  const Json& node = *place.schema;
  const Words said = words_of(node);
  std::vector<std::string> kinds;
  for (const Place* one : alike)
    if (!one->kind.empty()) kinds.push_back("\"" + one->kind + "\"");
  std::string head = toned(place.path, Tone::kStrong, stdout);
  if (!kinds.empty()) head += fmt::format(" of {}", fmt::join(kinds, ", "));
  std::vector<std::pair<std::string, std::string>> rows;
  const auto row = [&](const char* name, const std::string& text) {
    if (!text.empty()) rows.emplace_back(name, text);
  };
  row("meaning", said.meaning);
  row("type", type_of(node) + (place.required ? "; required" : ""));
  row("units", said.units.empty() || said.units.ends_with("without quotes")
                   ? said.units
                   : said.units + "; a plain number is in SI units");
  row("range", range_of(node));
  row("default", node.contains("default") ? node["default"].dump() : "");
  if (node.contains("examples"))
    row("example", fmt::format("\"{}\": {}", name_of(place), node["examples"][0].dump()));
  return head + "\n" + table(rows, width);
}

// The keys that come with a word, such as "annulus" or "table"; empty if there is no such word.
std::string keys_of_kind(const Places& places, const std::string& kind, int width) {
  std::map<std::string, std::vector<std::pair<std::string, std::string>>>
      rows;  // by the object that has them
  for (const Place& place : places.all)
    if (place.kind == kind)
      rows[place.path.substr(0, place.path.rfind('/'))].emplace_back(
          (place.required ? "* " : "  ") + name_of(place), row_of(place));
  std::string text;
  for (const auto& [path, keys] : rows)
    text += fmt::format("{}keys of {} \"{}\" (* is required)\n", text.empty() ? "" : "\n", path, kind) +
            table(keys, width);
  return text;
}

[[noreturn]] void refuse(const std::string& key, const Places& places) {
  std::vector<std::string> names, paths;
  for (const Place& place : places.all) {
    names.push_back(name_of(place));
    paths.push_back(place.path);
  }
  const std::string last = key.substr(key.rfind('/') + 1);
  std::vector<std::string> near = near_words(key, paths);
  for (const std::string& name : near_words(last, names))
    for (const std::string& path : paths)
      if (path == name || path.ends_with("/" + name)) near.push_back(path);
  std::set<std::string> told;
  std::erase_if(near, [&](const std::string& path) { return !told.insert(path).second; });
  constexpr std::size_t kMost = 8;
  if (near.size() > kMost) near.resize(kMost);
  throw InputError("command line", "", fmt::format("the key \"{}\"", key),
                   near.empty() ? "a key such as roughness/psd; `aberfit schema study` lists the blocks"
                                : fmt::format("keys of the study; similar ones: {}", fmt::join(near, ", ")));
}

}  // namespace

std::string explained_key(const Json& schema, const std::string& typed, int width) {
  const Places places(schema);
  const std::string key = typed.starts_with('/') ? typed.substr(1) : typed;
  if (key == "study" || key.empty())
    return wrapped(schema.value("description", ""), width) + "\n" + keys_below(places, nullptr, width);
  std::vector<const Place*> found;
  for (const bool alone : {false, true})
    if (found.empty())
      for (const Place& place : places.all)
        if (is_called(place, key, alone)) found.push_back(&place);
  if (found.empty()) {
    const std::string of_kind = keys_of_kind(places, key.substr(key.rfind('/') + 1), width);
    if (of_kind.empty()) refuse(key, places);
    return of_kind;
  }
  const auto elsewhere = [&](const Place* place) { return place->path != found.front()->path; };
  std::string text;
  if (std::any_of(found.begin(), found.end(), elsewhere)) {
    std::vector<std::pair<std::string, std::string>> rows;
    for (const Place* place : found)
      if (rows.empty() || rows.back().first != place->path) rows.emplace_back(place->path, row_of(*place));
    return fmt::format("several keys are called {}\n", key) + table(rows, width);
  }
  const std::string below = keys_below(places, found.front(), width);
  while (!found.empty()) {
    const Place& first = *found.front();
    const auto others = std::stable_partition(found.begin(), found.end(),
                                              [&](const Place* place) { return is_alike(*place, first); });
    text += (text.empty() ? "" : "\n") + explained({found.begin(), others}, width);
    found.erase(found.begin(), others);
  }
  return text + below;
}

}  // namespace aberfit::internal
