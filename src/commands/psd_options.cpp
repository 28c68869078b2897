#include "psd_options.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <string>
#include <string_view>

#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/study/measured_psd.h"

namespace aberfit::internal {
namespace {

using nlohmann::ordered_json;

// Returns a number if the whole text is one, so that plain SI numbers are allowed as in a study.
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

// Turns "annulus:outer=95%,inner=30%,centre=1mm,0mm" into the object of a study.
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
      if (object.contains(key)) refuse("every key once; \"" + key + "\" is given twice");
    }
    // A decimal comma, as in 1,5mm, would begin a second value.
    if (key.empty() || (equals == std::string_view::npos && key != "centre"))
      refuse(
          "SHAPE:key=value,..., e.g. \"circle:diameter=95%\", with decimal points; only centre has two "
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

// Turns "low=0.1/mm..1/mm,mid=1/mm..10/mm" into the list that a study has.
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

// Turns "0,-9999" into the list that a study has. Repeated options are joined by line ends.
ordered_json numbers_of(const std::string& text) {
  ordered_json numbers = ordered_json::array();
  for (const std::string_view number : words(text, ", \n"))
    numbers.push_back(option_value(std::string(number)));
  return numbers;
}

}  // namespace

ordered_json psd_options_block(const CommandLine& line) {
  ordered_json source = ordered_json::object(), block;
  for (const auto& [key, text] : line.psd_of_file)
    source[key] = key == "aperture"  ? aperture_object(text)
                  : key == "invalid" ? numbers_of(text)
                                     : option_value(text);
  // Many programs call von Hann's window "hanning".
  const auto is_hann = [](const std::string& text) { return lower_case(text) == "hanning"; };
  for (const auto& [key, text] : line.psd_of_block)
    block[key] = key == "bands"                     ? bands_of(text)
                 : key == "window" && is_hann(text) ? ordered_json("hann")
                                                    : option_value(text);
  for (const std::string& file : line.measured_files) {
    source["file"] = file;
    if (&file == &line.measured_files.front())
      block.update(source);
    else
      block["further"].push_back(source);
  }
  if (line.keep_lines) block["find_lines"] = false;
  return block;
}

}  // namespace aberfit::internal
