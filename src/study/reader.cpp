#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>

#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/study/parse_json.h"
#include "visitor.h"

namespace aberfit::internal {
namespace {

using Json = nlohmann::ordered_json;

std::string shown(const Json& json) {
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

std::string quoted_list(const std::vector<std::string>& names) {
  return fmt::format("\"{}\"", fmt::join(names, "\", \""));
}

std::string describe_range(Range range, Dimension dimension) {
  const bool low = std::isfinite(range.low), high = std::isfinite(range.high);
  std::string text;
  if (low) text += (range.low_open ? "above " : "at least ") + format_quantity(range.low, dimension);
  if (low && high) text += ", ";
  if (high) text += (range.high_open ? "below " : "at most ") + format_quantity(range.high, dimension);
  return text.empty() ? "finite" : text;
}

std::string describe_quantity(Dimension dimension) {
  if (dimension == Dimension::kNumber) return "a number (without unit)";
  return "a string with a unit (" + allowed_units(dimension) + ") or a plain number in SI units";
}

// 1e6 is an integer to a person but a floating-point number to the JSON library.
std::optional<std::int64_t> whole_number(const Json& json) {
  constexpr double kExact = 9007199254740992.0;  // 2^53
  if (json.is_number_unsigned()) {
    const auto value = json.get<std::uint64_t>();
    if (value > std::uint64_t(std::numeric_limits<std::int64_t>::max()))
      return std::numeric_limits<std::int64_t>::max();
    return std::int64_t(value);
  }
  if (json.is_number_integer()) return json.get<std::int64_t>();
  if (!json.is_number_float()) return std::nullopt;
  const double value = json.get<double>();
  if (std::trunc(value) != value || std::abs(value) > kExact) return std::nullopt;
  return std::int64_t(value);
}

std::string nearest(const std::string& word, const std::vector<std::string>& candidates) {
  const std::vector<std::string> near = near_words(word, candidates);
  return near.empty() ? "" : near.front();
}

// Finds the known key that is called `word` elsewhere: in other programs, in papers or as a symbol.
std::string known_as(const std::string& word, const std::vector<std::string>& known) {
  static const std::map<std::string, std::vector<std::string>> kOthers = {
      {"rms", {"sigma", "roughness", "height", "sq", "rq"}},
      {"wavelength", {"lambda", "wl"}},
      {"focal_length", {"f", "efl"}},
      {"diameter", {"d", "outer_diameter", "size"}},
      {"inner_diameter", {"obscuration", "central_obscuration", "hole"}},
      {"conic", {"k", "kappa", "conic_constant"}},
      {"exponent", {"slope", "c", "gamma", "power"}},
      {"B", {"b", "knee", "l0", "outer_scale"}},
      {"model", {"type", "kind"}}};
  const std::string folded = lower_case(word);
  for (const std::string& key : known)
    if (const auto others = kOthers.find(key); others != kOthers.end())
      if (std::find(others->second.begin(), others->second.end(), folded) != others->second.end()) return key;
  return nearest(word, known);
}

// The allowed text in place of `found`; a name that is near comes first.
std::string suggestion(const Json& found, const std::vector<std::string>& names, const std::string& allowed) {
  if (!found.is_string()) return allowed;
  const std::string near = nearest(found.get_ref<const std::string&>(), names);
  return near.empty() ? allowed : fmt::format("did you mean \"{}\"? allowed: {}", near, allowed);
}

// Compiling takes longer than reading a whole study, so we keep the few dozen compiled patterns.
bool matches(const std::string& text, const std::string& pattern) {
  thread_local std::map<std::string, std::regex> compiled;
  auto known = compiled.find(pattern);
  if (known == compiled.end()) known = compiled.emplace(pattern, std::regex(pattern)).first;
  return std::regex_match(text, known->second);
}

class Reader : public Visitor {
 public:
  // `json` and `file` must outlive the reader; `pointer` is where `json` stands in the file.
  Reader(const Json& json, const std::string& file, std::string pointer)
      : json_(json), file_(file), pointer_(std::move(pointer)) {}

  // Checks that json is an object with known keys only, then lets the body read it.
  void read(const Body& body, const char* note = nullptr);

  void quantity(const Field& field, std::optional<double>& value, Dimension dimension, Range range) override {
    if (const Json* json = find(field)) value = number(*json, at(field), field, dimension, range);
  }
  void quantities(const Field& field, std::vector<double>& values, Dimension dimension, Range range,
                  bool ascending) override {
    const Json* json = find(field);
    if (!json) return;
    if (!json->is_array() || json->empty()) fail(at(field), *json, "an array of at least one value", field);
    values.clear();
    for (std::size_t i = 0; i < json->size(); ++i) {
      const std::string pointer = at(field, std::to_string(i));
      const double value = number((*json)[i], pointer, field, dimension, range);
      if (ascending && !values.empty() && value <= values.back())
        fail(pointer, shown((*json)[i]), "ascending values, each once");
      values.push_back(value);
    }
  }
  void numbered_quantities(const Field& field, NumberedQuantities& values, int low, int high,
                           Dimension dimension, Range range) override {
    const Json* json = find(field);
    if (!json) return;
    const std::string keys = fmt::format("whole numbers from {} to {} as keys", low, high);
    if (!json->is_object() || json->empty())
      fail(at(field), *json, "an object of at least one value, " + keys, field);
    values.clear();
    for (const auto& item : json->items()) {
      const std::string& key = item.key();
      const std::string pointer = at(field, key);
      // Every int can hold this many digits. Signs and leading zeros are not allowed, so each number has one
      // name.
      static const std::regex whole_key("0|[1-9][0-9]{0,8}");
      if (!std::regex_match(key, whole_key) || std::stoi(key) < low || std::stoi(key) > high)
        fail(pointer, fmt::format("key \"{}\"", key), keys);
      values[std::stoi(key)] = number(item.value(), pointer, field, dimension, range);
    }
  }
  void word_or_quantity(const Field& field, WordOrQuantity& value, const std::string& regex,
                        Dimension dimension, Range range) override {
    const Json* json = find(field);
    if (!json) return;
    if (json->is_string() && matches(json->get_ref<const std::string&>(), regex)) {
      value = json->get<std::string>();
      return;
    }
    const std::string allowed =
        fmt::format("a word such as {}, or {}", field.example, describe_quantity(dimension));
    if (!json->is_number() && !json->is_string()) fail(at(field), *json, allowed, field);
    if (json->is_string()) {
      try {
        parse_quantity(json->get_ref<const std::string&>(), dimension);
      } catch (const UnitError& error) {
        fail(at(field), error.what(), allowed);
      }
    }
    value = number(*json, at(field), field, dimension, range);
  }
  void points(const Field& field, Points& points, std::size_t least) override {
    const Json* json = find(field);
    if (!json) return;
    if (!json->is_array()) fail(at(field), *json, "an array of [x, y]", field);
    if (json->size() < least)
      fail(at(field), fmt::format("{} points", json->size()),
           fmt::format("at least {} points [x, y]", least));
    points.clear();
    for (std::size_t i = 0; i < json->size(); ++i) {
      const std::string pointer = at(field, std::to_string(i));
      const Json& pair = (*json)[i];
      if (!pair.is_array() || pair.size() != 2) fail(pointer, pair, "[x, y]", field);
      std::array<double, 2> point{};
      for (std::size_t k = 0; k < 2; ++k)
        point[k] = number(pair[k], child_pointer(pointer, std::to_string(k)), field, Dimension::kLength,
                          Range::any());
      points.push_back(point);
    }
  }
  void integer(const Field& field, std::optional<std::int64_t>& value, std::int64_t low,
               std::int64_t high) override {
    const Json* json = find(field);
    if (!json) return;
    const std::string allowed =
        low == high ? fmt::format("the integer {}", low) : fmt::format("an integer from {} to {}", low, high);
    value = whole(*json, field, low, high, allowed);
  }
  void seed(const Field& field, std::uint64_t& value) override {
    const Json* json = find(field);
    if (!json) return;
    const std::int64_t number = whole(*json, field, 0, std::numeric_limits<std::int64_t>::max(),
                                      "an integer from 0 to 18446744073709551615");
    value = json->is_number_float() ? std::uint64_t(number) : json->get<std::uint64_t>();
  }
  void boolean(const Field& field, bool& value) override {
    const Json* json = find(field);
    if (!json) return;
    if (!json->is_boolean()) fail(at(field), *json, "true or false", field);
    value = json->get<bool>();
  }
  void text(const Field& field, std::string& value, bool may_be_empty) override {
    const Json* json = find(field);
    if (!json) return;
    if (!json->is_string()) fail(at(field), *json, "a string", field);
    if (!may_be_empty && json->get_ref<const std::string&>().empty())
      fail(at(field), *json, "a string with text", field);
    value = json->get<std::string>();
  }
  void texts(const Field& field, Names& values, std::size_t least, std::size_t most) override {
    const Json* json = find(field);
    if (!json) return;
    const std::string allowed = least == most
                                    ? fmt::format("an array of {} strings", least)
                                    : fmt::format("an array of {} to {} strings with text", least, most);
    if (!json->is_array() || json->size() < least || json->size() > most)
      fail(at(field), *json, allowed, field);
    values.clear();
    for (std::size_t i = 0; i < json->size(); ++i) {
      const Json& item = (*json)[i];
      if (!item.is_string() || item.get_ref<const std::string&>().empty())
        fail(at(field, std::to_string(i)), item, "a string with text", field);
      values.push_back(item.get<std::string>());
    }
  }
  void texts_by_key(const Field& field, TextsByKey& values, const std::vector<KeyPattern>& patterns,
                    const std::string& regex) override {
    const Json* json = find(field);
    if (!json) return;
    const std::string allowed = fmt::format("an object such as {}", field.example);
    if (!json->is_object() || json->empty()) fail(at(field), *json, allowed, field);
    values.clear();
    for (const auto& item : json->items()) {
      check_key(field, item.key(), patterns);
      const Json& text = item.value();
      if (!text.is_string() || !matches(text.get_ref<const std::string&>(), regex))
        fail(at(field, item.key()), text, "a string as in " + std::string(field.example), field);
      values.emplace_back(item.key(), text.get<std::string>());
    }
  }
  void variations(const Field& field, TextsByKey& values) override {
    const Json* json = find(field);
    if (!json) return;
    if (!json->is_object() || json->empty())
      fail(at(field), *json, fmt::format("an object such as {}", field.example), field);
    values.clear();
    for (const auto& item : json->items()) {
      if (!item.key().starts_with('/'))
        fail(at(field, item.key()), fmt::format("key \"{}\"", item.key()),
             "JSON pointers into the study, which begin with /, as keys");
      const Json& value = item.value();
      if (!value.is_object() && (!value.is_array() || value.empty()))
        fail(at(field, item.key()), value,
             "an array of at least one value, or a range {\"from\": ..., \"to\": ..., \"count\": ...}",
             field);
      values.emplace_back(item.key(), value.dump());
    }
  }
  void choice(const Field& field, std::size_t& index, const Names& names) override {
    const Json* json = find(field);
    if (!json) return;
    if (json->is_string()) {
      const auto found = std::find(names.begin(), names.end(), json->get_ref<const std::string&>());
      if (found != names.end()) {
        index = std::size_t(found - names.begin());
        return;
      }
    }
    fail(at(field), *json, suggestion(*json, names, quoted_list(names)), field);
  }
  void choices(const Field& field, std::vector<std::size_t>& indices, const Names& names) override {
    const Json* json = find(field);
    if (!json) return;
    const std::string allowed = "an array of some of " + quoted_list(names) + ", each at most once";
    if (!json->is_array()) fail(at(field), *json, allowed, field);
    indices.clear();
    for (std::size_t i = 0; i < json->size(); ++i) {
      const Json& item = (*json)[i];
      const auto found =
          item.is_string() ? std::find(names.begin(), names.end(), item.get<std::string>()) : names.end();
      const auto index = std::size_t(found - names.begin());
      if (found == names.end())
        fail(at(field, std::to_string(i)), item, suggestion(item, names, allowed), field);
      if (std::find(indices.begin(), indices.end(), index) != indices.end())
        fail(at(field, std::to_string(i)), item, allowed, field);
      indices.push_back(index);
    }
  }
  void object(const Field& field, bool* present, const Body& body, const char*) override {
    const Json* json = find(field);
    if (present) *present = json != nullptr;
    if (json) inside(*json, at(field)).read(body, field.note);
  }
  void word_or_object(const Field& field, bool& is_object, const Names& words, std::size_t& word,
                      const Body& body) override {
    const Json* json = find(field);
    if (!json) return;
    is_object = json->is_object();
    if (is_object) return inside(*json, at(field)).read(body);
    word = std::size_t(std::find(words.begin(), words.end(), *json) - words.begin());
    if (word == words.size())
      fail(at(field), *json,
           suggestion(*json, words, fmt::format("\"{}\" or an object", fmt::join(words, "\", \""))), field);
  }
  void word_or_integer(const Field& field, bool& is_word, const std::string& word, std::int64_t& value,
                       std::int64_t low, std::int64_t high) override {
    const Json* json = find(field);
    if (!json) return;
    is_word = *json == word;
    if (is_word) return;
    const std::string allowed = fmt::format("\"{}\" or an integer from {} to {}", word, low, high);
    value = whole(*json, field, low, high, suggestion(*json, {word}, allowed));
  }
  void list(const Field& field, std::size_t, std::size_t least, const Resize& resize, const ItemBody& body,
            const char*) override {
    const Json* json = find(field);
    if (!json) return;
    if (!json->is_array() || json->size() < least)
      fail(at(field), *json, fmt::format("an array of at least {} objects", least), field);
    resize(json->size());
    for (std::size_t i = 0; i < json->size(); ++i)
      inside((*json)[i], at(field, std::to_string(i))).read([&](Visitor& v) { body(v, i); });
  }
  void keyed(const Field& field, Names& keys, const std::vector<KeyPattern>& patterns,
             const ItemBody& body) override {
    const Json* json = find(field);
    keys.clear();
    if (!json) return;
    if (!json->is_object()) fail(at(field), *json, "an object", field);
    for (const auto& item : json->items()) {
      check_key(field, item.key(), patterns);
      keys.push_back(item.key());
    }
    for (std::size_t i = 0; i < keys.size(); ++i)
      inside((*json)[keys[i]], at(field, keys[i])).read([&](Visitor& v) { body(v, i); });
  }
  void check(bool holds, const std::string& key, const std::string& found,
             const std::string& allowed) override {
    if (!holds) fail(key.empty() ? pointer_ : pointer_ + '/' + key, found, allowed);
  }
  bool reading() const override { return true; }

 protected:
  // The value of the key; null if an optional key is absent. Throws if a required key is absent.
  virtual const Json* find(const Field& field) {
    const auto found = json_.find(field.key);
    if (found != json_.end()) return &*found;
    if (field.need == Need::kRequired)
      fail(at(field), kMissing, fmt::format("{} needs {} ({})", name(), with_example(field), field.meaning));
    return nullptr;
  }
  static std::string with_example(const Field& field) {
    return fmt::format("\"{}\": {}", field.key, field.example ? field.example : "...");
  }
  // The name of the object being read, for messages.
  std::string name() const { return pointer_.empty() ? "a study" : pointer_.substr(1); }
  Reader inside(const Json& json, const std::string& pointer) const { return Reader(json, file_, pointer); }

  const Json& json_;
  const std::string& file_;
  std::string pointer_;

 private:
  [[noreturn]] void fail(const std::string& pointer, const std::string& found,
                         const std::string& allowed) const {
    throw InputError(file_, pointer, found, allowed);
  }
  [[noreturn]] void fail(const std::string& pointer, const Json& found, const std::string& allowed,
                         const Field& field) const {
    fail(pointer, shown(found), field.note ? allowed + ". " + field.note : allowed);
  }
  double number(const Json& json, const std::string& pointer, const Field& field, Dimension dimension,
                Range range) const {
    double value = 0;
    if (json.is_number()) {
      value = json.get<double>();
    } else if (json.is_string() && dimension != Dimension::kNumber) {
      try {
        value = parse_quantity(json.get_ref<const std::string&>(), dimension);
      } catch (const UnitError& error) {
        fail(pointer, error.what(),
             fmt::format("a text such as {}, or a plain number in SI units",
                         field.example ? field.example : "\"1 \" and a unit"));
      }
    } else {
      fail(pointer, json, describe_quantity(dimension), field);
    }
    for (const Range& allowed : {range, within_reach(range, dimension)})
      if (!allowed.contains(value))
        fail(pointer, fmt::format("{} ({})", shown(json), format_quantity(value, dimension)),
             describe_range(allowed, dimension) +
                 (json.is_number() && dimension != Dimension::kNumber && field.example
                      ? fmt::format(". A plain number is in SI units; with its unit it is a text such as {}",
                                    field.example)
                      : ""));
    return value;
  }
  std::int64_t whole(const Json& json, const Field& field, std::int64_t low, std::int64_t high,
                     const std::string& allowed) const {
    const std::optional<std::int64_t> value = whole_number(json);
    if (!value || *value < low || *value > high) fail(at(field), json, allowed, field);
    return *value;
  }
  // Checks a key that is data.
  void check_key(const Field& field, const std::string& key, const std::vector<KeyPattern>& patterns) const {
    for (const KeyPattern& pattern : patterns)
      if (pattern.regex.empty() ? key == pattern.literal : matches(key, pattern.regex)) return;
    std::vector<std::string> samples;
    std::string near;
    const std::string folded = lower_case(key);
    for (const KeyPattern& pattern : patterns) {
      samples.push_back(pattern.sample);
      if (!pattern.regex.empty() && matches(folded, pattern.regex)) near = folded;
    }
    if (near.empty()) near = nearest(key, samples);
    fail(at(field, key), fmt::format("unknown key \"{}\"", key),
         fmt::format("{}keys like {}", near.empty() ? "" : "did you mean \"" + near + "\"? ",
                     quoted_list(samples)));
  }
  std::string at(const Field& field) const { return child_pointer(pointer_, field.key); }
  std::string at(const Field& field, const std::string& item) const { return child_pointer(at(field), item); }
};

// Runs a description to learn its keys before anything is read, so that a misspelt required key is reported
// as misspelt, not as missing. This reader finds no keys except tags, because the other keys depend on them;
// so it goes only one level deep.
class KnownKeys : public Reader {
 public:
  using Reader::Reader;
  Names known, missing, usual;

  // Without the tag the other keys are not known.
  void tag(const Field& field, std::size_t& index, const Names& names) override {
    known.emplace_back(field.key);
    if (!json_.contains(field.key))
      throw InputError(file_, child_pointer(pointer_, field.key), kMissing,
                       fmt::format("{} needs \"{}\", one of {}", name(), field.key, quoted_list(names)));
    inside(json_, pointer_).choice(field, index, names);
  }
  void check(bool, const std::string&, const std::string&, const std::string&) override {}
  bool reading() const override { return false; }

 private:
  const Json* find(const Field& field) override {
    known.emplace_back(field.key);
    if (!json_.contains(field.key) && field.need != Need::kOptional)
      (field.need == Need::kRequired ? missing : usual).push_back(with_example(field));
    return nullptr;
  }
};

void Reader::read(const Body& body, const char* note) {
  if (!json_.is_object()) fail(pointer_, json_, "an object", Field{"", "", Need::kOptional, nullptr, note});
  KnownKeys keys(json_, file_, pointer_);
  body(keys);
  for (const auto& item : json_.items()) {
    if (std::find(keys.known.begin(), keys.known.end(), item.key()) != keys.known.end()) continue;
    const std::string pointer = child_pointer(pointer_, item.key());
    std::string allowed = quoted_list(keys.known);
    const std::string near = known_as(item.key(), keys.known);
    if (!near.empty()) allowed = fmt::format("did you mean \"{}\"? known keys: {}", near, allowed);
    fail(pointer, fmt::format("unknown key \"{}\"", item.key()), allowed);
  }
  // If only one key is missing, `find` reports it with its meaning.
  keys.missing.insert(keys.missing.end(), keys.usual.begin(),
                      keys.missing.empty() ? keys.usual.begin() : keys.usual.end());
  if (keys.missing.size() > 1)
    fail(pointer_, kMissing, fmt::format("{} needs {}", name(), fmt::join(keys.missing, ", ")));
  body(*this);
}

}  // namespace

void read_object(const Json& json, const std::string& file, const Visitor::Body& body) {
  Reader(json, file, "").read(body);
}

}  // namespace aberfit::internal
