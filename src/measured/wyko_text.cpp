#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "instrument_text.h"
#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

// Reads words one after another, whatever lines they are in.
class WordsOfLines {
 public:
  explicit WordsOfLines(TextLines* lines) : lines_(lines) {}
  std::string_view next(const char* wanted) {
    while (at_ == words_.size()) {
      std::string_view line;
      if (!lines_->next(&line)) lines_->fail("the end of the file", wanted);
      find_words(line, kBlanks, &words_);
      at_ = 0;
    }
    return words_[at_++];
  }

 private:
  TextLines* lines_;
  std::vector<std::string_view> words_;
  std::size_t at_ = 0;
};

// Returns the fields between tabs: name, type, length, value.
std::vector<std::string> wyko_fields(std::string_view line) {
  std::vector<std::string> fields;
  for (std::size_t begin = 0;;) {
    const std::size_t end = line.find('\t', begin);
    fields.emplace_back(trimmed(line.substr(begin, end - begin)));
    if (end == std::string_view::npos) return fields;
    begin = end + 1;
  }
}

struct WykoText {
  bool in_nanometres = false;
  std::int64_t columns = 0, rows = 0;
  std::map<std::string, std::string> values;

  std::optional<double> number(const std::string& path, const std::string& name) const {
    const auto found = values.find(name);
    if (found == values.end() || found->second.empty()) return std::nullopt;
    const std::optional<double> value = parse_finite(found->second);
    if (!value) throw InputError(path, name, in_quotes(found->second), "a number");
    return value;
  }
};

std::int64_t wyko_size(const TextLines& lines, const std::string& text) {
  const std::optional<std::int64_t> size = parse_number<std::int64_t>(text);
  if (!size || *size < 1) lines.fail(in_quotes(text), "a whole number above zero");
  return *size;
}

// Reads up to the first block of heights, whose numbers come next. Other arrays are skipped.
WykoText wyko_header(const std::string& path, TextLines* lines) {
  static const std::vector<std::string> kHeights = {"Raw", "RAW DATA", "RAW_DATA", "OPD", "SAMPLE_DATA"};
  WykoText header;
  std::string_view line;
  lines->next(&line);
  if (!line.starts_with(kWykoTextTitle)) lines->fail(in_quotes(line), fmt::format("'{}'", kWykoTextTitle));
  const std::vector<std::string_view> flags = words(line.substr(kWykoTextTitle.size()));
  // The second flag distinguishes nanometres from fractions of the wavelength.
  header.in_nanometres = flags.size() > 1 && flags[1] == "1";
  while (lines->next(&line)) {
    const std::vector<std::string> fields = wyko_fields(line);
    const std::string& name = fields.front();
    if (name == "X Size" && fields.size() > 1) header.columns = wyko_size(*lines, fields[1]);
    if (name == "Y Size" && fields.size() > 1) header.rows = wyko_size(*lines, fields[1]);
    if (fields.size() < 3 || name == "Block Name") continue;
    const bool array = fields[1] == "3";
    if (!array) {
      header.values[name] = fields.size() > 3 ? fields[3] : "";
      continue;
    }
    require_map_size(path, fmt::format("line {}", lines->number()), header.columns, header.rows);
    if (std::uint64_t(header.columns) * std::uint64_t(header.rows) > lines->bytes_left())
      lines->fail(fmt::format("{} x {} points", header.columns, header.rows),
                  fmt::format("as many as {} bytes can hold", lines->bytes_left()));
    if (std::find(kHeights.begin(), kHeights.end(), name) != kHeights.end()) return header;
    WordsOfLines passed(lines);
    for (std::int64_t i = 0; i < header.columns * header.rows; ++i) passed.next("the rest of an array");
  }
  throw InputError(path, "", "no block of heights", "a block Raw, RAW DATA, RAW_DATA, OPD or SAMPLE_DATA");
}

// Returns the height [m] of one unit of the file.
double wyko_factor(const MeasuredSource& source, const WykoText& header) {
  if (header.in_nanometres) return agreed_value_factor(source, 1e-9, "nm");
  constexpr double kShortest = 1, kLongest = 1e6;  // [nm]
  const std::optional<double> said = header.number(source.path, "Wavelength");
  const bool sane = said && *said >= kShortest && *said <= kLongest;
  if (!sane && !source.wavelength)
    throw MissingFact("wavelength", source.path, "Wavelength", said ? fmt::format("{} nm", *said) : "nothing",
                      "1 to 1e6 nm, or option 'wavelength'");
  const double wavelength =
      *agreed_length(source.path, "wavelength", source.wavelength,
                     sane ? std::optional(*said * 1e-9) : std::nullopt, kSameWavelength);
  const double parts = header.number(source.path, "Mult").value_or(1);
  if (!(parts > 0))
    throw InputError(source.path, "Mult", fmt::format("{}", parts),
                     "a positive number, the counts per wavelength");
  return agreed_value_factor(source, wavelength / parts, "Wavelength / Mult");
}

}  // namespace

HeightMap read_wyko_text(const MeasuredSource& source) {
  require_sane_options(source);
  TextLines lines(source.path);
  const WykoText header = wyko_header(source.path, &lines);
  agreed_wavefront(source.path, source.wavefront, false);
  const double factor = wyko_factor(source, header);
  // Pitch of a pixel along y over that along x.
  const double aspect = header.number(source.path, "Aspect").value_or(1);
  if (!(aspect > 0)) throw InputError(source.path, "Aspect", fmt::format("{}", aspect), "a positive number");
  const double pitch =
      agreed_pitch(source, header.number(source.path, "Pixel_size").value_or(0) * 1e-3);  // the file has mm
  HeightMap map = empty_map(header.rows, header.columns, pitch, pitch * aspect);
  map.file_unit = factor;
  if (const auto title = header.values.find("Title"); title != header.values.end())
    map.label = one_line(title->second, 80);
  // As in the binary file, each line is a column from its lowest point upwards.
  WordsOfLines words_of_heights(&lines);
  for (Eigen::Index column = 0; column < map.columns(); ++column)
    for (Eigen::Index row = 0; row < map.rows(); ++row) {
      const std::string_view word = words_of_heights.next("the rest of the heights");
      if (lower_case(word) == "bad") continue;
      const std::optional<double> value = parse_finite(word);
      if (!value) lines.fail(in_quotes(word), "a number, or Bad for no data");
      map.height(row, column) = factor * *value;
    }
  return map;
}

}  // namespace aberfit
