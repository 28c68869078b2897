#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/measured/read_measurement.h"
#include "instrument_text.h"
#include "is_4d_hdf5.h"
#include "matrix_axes.h"
#include "text_columns.h"

namespace aberfit {
using namespace internal;

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kHead = 8192;

bool is_dabam_metadata(std::string_view head) {
  if (head.starts_with("\xef\xbb\xbf")) head.remove_prefix(3);
  const std::size_t first = head.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && head[first] == '{' &&
         head.find("\"FILE_FORMAT\"") != std::string_view::npos;
}

MeasuredFormat format_of_magic(std::string_view head) {
  using enum MeasuredFormat;
  static constexpr std::pair<std::string_view, MeasuredFormat> kMagic[] = {{"\x88\x1b\x03\x6f", kZygo},
                                                                           {"\x88\x1b\x03\x70", kZygo},
                                                                           {"\x88\x1b\x03\x71", kZygo},
                                                                           {"SIMPLE  =", kFits},
                                                                           {"\x1f\x8b", kFits},
                                                                           {"\x93NUMPY", kNpy},
                                                                           {"\x89HDF\r\n\x1a\n", kDatx},
                                                                           {"PK\x03\x04", kX3p},
                                                                           {{"\x01\0Directory", 11}, kOpd},
                                                                           {"aISO-", kSdf},
                                                                           {"bISO-", kSdf},
                                                                           {"aBCR-", kSdf},
                                                                           {"bBCR-", kSdf}};
  for (const auto& [magic, format] : kMagic)
    if (head.starts_with(magic)) return format;
  return kAuto;
}

// Returns the head as text in the form that the line readers see.
std::string plain_text(std::string_view head) {
  const std::string text = utf8_text(head);
  std::string plain;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    plain += with_plain_blanks(std::string_view(text).substr(begin, end - begin));
    begin = end;
  }
  return plain;
}

// True if `path` is the .txt, the .dat beside a .txt, or the common name without suffix.
bool is_dabam(const std::string& path, const std::optional<std::string>& head) {
  if (head && is_dabam_metadata(*head)) return true;
  const fs::path name(path);
  const bool data = lower_case(name.extension().string()) == ".dat";
  if (!data && head) return false;
  const std::optional<std::string> metadata =
      file_bytes(data ? fs::path(name).replace_extension(".txt").string() : path + ".txt", kHead);
  return metadata && is_dabam_metadata(*metadata);
}

MeasuredFormat format_of_title(std::string_view line) {
  if (line.starts_with(kZygoXyzTitle) || line.starts_with(kZygoAsciiTitle)) return MeasuredFormat::kZygoText;
  if (line.starts_with(kWykoTextTitle)) return MeasuredFormat::kWykoText;
  return MeasuredFormat::kAuto;
}

// The sizes and the heights look like a profile of one column; the notes at the end of the file do not.
bool is_dftfringe(const std::string& path, const std::vector<std::string_view>& lines) {
  if (lines.size() < 3) return false;
  for (std::size_t i = 0; i < 2; ++i)
    if (const auto size = parse_number<long>(lines[i]); !size || *size < 2) return false;
  constexpr std::streamoff kTail = 1024;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file.tellg(), length = std::min(size, kTail);
  std::string tail(std::size_t(std::max<std::streamoff>(length, 0)), '\0');
  file.seekg(size - length);
  if (!file.read(tail.data(), length)) return false;
  for (const std::string_view line : words(tail, "\r\n"))
    for (const char* key : {"outside ", "DIAM ", "Lambda "})
      if (line.starts_with(key)) return true;
  return false;
}

// Splits the head into lines. An incomplete last line is kept, without its last field, only if it is long.
std::vector<std::string_view> lines_of(std::string_view head, bool cut) {
  constexpr std::size_t kLong = kHead / 4;
  std::vector<std::string_view> lines = words(head, "\r\n");
  for (std::string_view& line : lines) line = trimmed(line);
  if (cut && !lines.empty() && head.find_last_of("\r\n") + 1 != head.size()) {
    std::string_view& last = lines.back();
    const std::size_t separator = last.find_last_of(" \t,;");
    if (last.size() < kLong || separator == std::string_view::npos)
      lines.pop_back();
    else
      last = trimmed(last.substr(0, separator));
  }
  return lines;
}

// Returns true for comments with '!', a title, then "GRD nx ny ..." or "ZFR n ...".
bool is_codev_int(const std::vector<std::string_view>& lines) {
  int seen = 0;
  for (const std::string_view line : lines) {
    if (line.empty() || line.front() == '!') continue;
    if (line.starts_with("GRD ") || line.starts_with("ZFR ")) return true;
    if (++seen == 2) return false;
  }
  return false;
}

std::optional<std::vector<double>> numbers_of(std::string_view line) {
  std::vector<std::string_view> fields;
  split(line, delimiter_of(line), &fields);
  std::vector<double> numbers;
  for (const std::string_view field : fields) {
    const std::optional<double> number = parse_cell(field);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

// Returns true for the header nx ny delx dely unitflag xdec ydec, then lines of four or five numbers.
bool is_zemax_grid_sag(const std::vector<std::string_view>& lines) {
  std::size_t seen = 0;
  for (const std::string_view line : lines) {
    if (line.empty() || line.front() == '!') continue;
    const auto numbers = numbers_of(line);
    if (!numbers) return false;
    const auto count = [](double n) { return n >= 5 && n == std::floor(n); };
    if (seen == 0 && !(numbers->size() == 7 && count((*numbers)[0]) && count((*numbers)[1]))) return false;
    if (seen > 0 && numbers->size() != 4 && numbers->size() != 5) return false;
    ++seen;
  }
  return seen >= 2;
}

// Columns are a map if the file declares one or the first column is not monotonic, otherwise a profile.
MeasuredFormat columns_format(const std::vector<std::string_view>& lines, bool cut) {
  std::size_t columns = 0, rows = 0;
  bool map_key = false, profile_key = false, ascending = true, descending = true;
  bool names_seen = false, units_seen = false;
  std::vector<std::vector<double>> first_rows;  // enough of them to recognise axes
  bool same_second = true;
  double before = 0, second = 0;
  for (const std::string_view& whole : lines) {
    std::string_view line = whole;
    if (line.starts_with("#")) {
      const auto key = comment_key(line);
      map_key =
          map_key || (key && (key->first == "pitch" || key->first == "layout" || key->first == "width"));
      profile_key = profile_key || (key && key->first == "quantity");
      continue;
    }
    line = trimmed(before_comment(line));
    if (line.empty()) continue;
    const auto numbers = numbers_of(line);
    if (!numbers && rows == 0 && !names_seen && !decimal_comma(line)) {
      names_seen = true;
      continue;
    }
    if (!numbers && rows == 0 && !units_seen && is_unit_row(line)) {
      units_seen = true;
      continue;
    }
    // The last row of the head may be incomplete.
    if (cut && numbers && rows > 0 && numbers->size() < columns && &whole == &lines.back()) continue;
    if (!numbers || (rows > 0 && numbers->size() != columns)) return MeasuredFormat::kAuto;
    columns = numbers->size();
    const double first = numbers->front();
    // Points x, y, height follow a row of the map: x ascends and y stays constant.
    if (columns == 3 && rows > 0) same_second = same_second && (*numbers)[1] == second;
    if (columns == 3) second = (*numbers)[1];
    if (rows > 0) {
      ascending = ascending && first > before;
      descending = descending && first < before;
    }
    before = first;
    ++rows;
    if (first_rows.size() < kLeastOnAxis + 1) first_rows.push_back(*numbers);
  }
  if (rows == 0) return MeasuredFormat::kAuto;
  if (map_key) return MeasuredFormat::kMapText;
  if (columns == 1) return MeasuredFormat::kProfileText;  // its reader reports what is missing
  if (profile_key || columns == 2) return MeasuredFormat::kProfileText;
  if (columns == 3 && same_second) return MeasuredFormat::kMapText;
  if (has_axes(first_rows)) return MeasuredFormat::kMapText;
  return rows > 1 && (ascending || descending) ? MeasuredFormat::kProfileText : MeasuredFormat::kMapText;
}

}  // namespace

MeasuredFormat detect_format(const std::string& path) {
  std::optional<std::string> head = file_bytes(path, kHead);
  if (head)
    if (const MeasuredFormat format = format_of_magic(*head); format != MeasuredFormat::kAuto)
      return format == MeasuredFormat::kDatx && is_4d_hdf5(path) ? MeasuredFormat::kFourD : format;
  if (is_dabam(path, head)) return MeasuredFormat::kDabam;
  if (!head) throw InputError(path, "", "a file that cannot be opened", "the name of a readable file");
  const bool cut = head->size() == kHead;
  head = plain_text(*head);
  if (head->find('\0') != std::string::npos) return MeasuredFormat::kAuto;
  const std::vector<std::string_view> lines = lines_of(*head, cut);
  if (lines.empty()) return MeasuredFormat::kAuto;
  if (const MeasuredFormat format = format_of_title(lines.front()); format != MeasuredFormat::kAuto)
    return format;
  if (is_dftfringe(path, lines)) return MeasuredFormat::kDftfringe;
  if (is_codev_int(lines)) return MeasuredFormat::kCodeVInt;
  if (is_zemax_grid_sag(lines)) return MeasuredFormat::kZemaxGridSag;
  return columns_format(lines, cut);
}

const std::vector<std::string>& measured_format_names() {
  static const std::vector<std::string> names = {
      "auto",      "dabam",          "profile",   "map", "zygo", "codev-int",
      "fits",      "zemax-grid-sag", "datx",      "opd", "sdf",  "x3p",
      "zygo-text", "wyko-text",      "dftfringe", "4d",  "npy"};
  return names;
}

std::string measured_format_list() {
  std::string list;
  for (std::size_t i = 1; i < measured_format_names().size(); ++i)
    list += (i > 1 ? ", " : "") + measured_format_names()[i];
  return list;
}

std::string to_string(MeasuredFormat format) { return measured_format_names()[std::size_t(format)]; }

}  // namespace aberfit
