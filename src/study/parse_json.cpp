#include "aberfit/study/parse_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"

namespace aberfit {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::size_t kDeepest = 64;
constexpr std::string_view kCommented = ".jsonc";

// nlohmann-json silently keeps the last of two equal keys; this pass over the text finds them.
class KeyCheck : public nlohmann::json_sax<Json> {
 public:
  KeyCheck(const std::string& text, const std::string& path) : text_(text), path_(path) {}

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value(); }
  bool number_unsigned(number_unsigned_t) override { return value(); }
  bool number_float(number_float_t, const string_t&) override { return value(); }
  bool string(string_t&) override { return value(); }
  bool binary(binary_t&) override { return value(); }
  bool start_object(std::size_t) override { return open(false); }
  bool start_array(std::size_t) override { return open(true); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    Level& level = levels_.back();
    level.key = name;
    if (!level.keys.insert(name).second)
      throw InputError(path_, pointer(), fmt::format("key \"{}\" twice", name),
                       "every key once in an object");
    return true;
  }
  bool parse_error(std::size_t position, const std::string& token,
                   const nlohmann::detail::exception& error) override {
    const std::size_t at = std::min(position > 0 ? position - 1 : 0, text_.size());
    const std::size_t line =
        1 + std::size_t(std::count(text_.begin(), text_.begin() + std::ptrdiff_t(at), '\n'));
    const std::size_t start = at == 0 ? std::string::npos : text_.rfind('\n', at - 1);
    const std::size_t column = start == std::string::npos ? at + 1 : at - start;
    const std::string place = fmt::format("line {}, column {}", line, column);
    if (const std::string_view rest = std::string_view(text_).substr(at);
        (rest.starts_with("//") || rest.starts_with("/*")) && !path_.ends_with(kCommented))
      throw InputError(path_, "", "a comment at " + place,
                       "no comments in JSON (RFC 8259); to use comments, name the file .jsonc");
    // The end of the library's message says what was found. Our message gives the position in its own words.
    std::string reason = error.what();
    if (const std::size_t cut = reason.find("; "); cut != std::string::npos) reason = reason.substr(cut + 2);
    throw InputError(
        path_, "", fmt::format("invalid JSON at {}, near \"{}\" ({})", place, token.substr(0, 40), reason),
        "JSON (RFC 8259) with finite numbers and no trailing commas; comments only in a .jsonc file");
  }

 private:
  struct Level {
    bool array;
    std::size_t index;
    std::string key;
    std::set<std::string> keys;
  };

  std::string pointer() const {
    std::string result;
    for (const Level& level : levels_)
      result = child_pointer(result, level.array ? std::to_string(level.index) : level.key);
    return result;
  }
  bool value() {
    if (!levels_.empty()) ++levels_.back().index;
    return true;
  }
  bool open(bool array) {
    if (levels_.size() == kDeepest)
      throw InputError(path_, pointer(), "deeper nesting", fmt::format("at most {} levels", kDeepest));
    levels_.push_back({array, 0, "", {}});
    return true;
  }
  bool close() {
    levels_.pop_back();
    return value();
  }

  const std::string& text_;
  const std::string& path_;
  std::vector<Level> levels_;
};

}  // namespace

std::string child_pointer(const std::string& pointer, const std::string& key) {
  std::string result = pointer + '/';
  for (const char c : key) {
    if (c == '~')
      result += "~0";
    else if (c == '/')
      result += "~1";
    else
      result += c;
  }
  return result;
}

Json parse_json(const std::string& text, const std::string& path) {
  if (trimmed(text).empty())
    throw InputError(path, "", "an empty file", "a study file (JSON), see `aberfit schema`");
  KeyCheck check(text, path);
  const bool commented = path.ends_with(kCommented);
  Json::sax_parse(text, &check, nlohmann::detail::input_format_t::json, true, commented);
  return Json::parse(text, nullptr, true, commented);
}

}  // namespace aberfit
