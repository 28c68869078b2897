#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/measured/read_measurement.h"
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

// The formats that begin with bytes of their own.
MeasuredFormat format_of_magic(std::string_view head) {
  using enum MeasuredFormat;
  static constexpr std::pair<std::string_view, MeasuredFormat> kMagic[] = {{"\x88\x1b\x03\x6f", kZygo},
                                                                           {"\x88\x1b\x03\x70", kZygo},
                                                                           {"\x88\x1b\x03\x71", kZygo},
                                                                           {"SIMPLE  =", kFits},
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

// Of the .txt, of the .dat beside a .txt, or of the path without suffix.
bool is_dabam(const std::string& path, const std::optional<std::string>& head) {
  if (head && is_dabam_metadata(*head)) return true;
  const fs::path name(path);
  const bool data = lower_case(name.extension().string()) == ".dat";
  if (!data && head) return false;
  const std::optional<std::string> metadata =
      file_bytes(data ? fs::path(name).replace_extension(".txt").string() : path + ".txt", kHead);
  return metadata && is_dabam_metadata(*metadata);
}

// Lines of the head. A last one that is cut off stays only when it is long, as a row of a matrix is; its last
// field goes.
std::vector<std::string_view> lines_of(std::string_view head) {
  constexpr std::size_t kLong = kHead / 4;
  const bool cut = head.size() == kHead;
  if (head.starts_with("\xef\xbb\xbf")) head.remove_prefix(3);
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

// Comments with '!', a title, then "GRD nx ny ..." or "ZFR n ...".
bool is_codev_int(const std::vector<std::string_view>& lines) {
  int seen = 0;
  for (const std::string_view line : lines) {
    if (line.empty() || line.front() == '!') continue;
    if (line.starts_with("GRD ") || line.starts_with("ZFR ")) return true;
    if (++seen == 2) return false;
  }
  return false;
}

// Numbers of a line; nothing when a field is none.
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

// nx ny delx dely unitflag xdec ydec, then lines of four numbers or five.
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

// Columns of numbers: a map when the file says so or when the first column does not go one way, else a
// profile.
MeasuredFormat columns_format(const std::vector<std::string_view>& lines, bool cut) {
  std::size_t columns = 0, rows = 0;
  bool map_key = false, profile_key = false, ascending = true, descending = true, names_seen = false;
  bool same_second = true;
  double before = 0, second = 0;
  for (const std::string_view& whole : lines) {
    std::string_view line = whole;
    if (line.starts_with("#")) {
      const auto key = comment_key(line);
      map_key = map_key || (key && (key->first == "pitch" || key->first == "layout"));
      profile_key = profile_key || (key && key->first == "quantity");
      continue;
    }
    line = trimmed(before_comment(line));
    if (line.empty()) continue;
    const auto numbers = numbers_of(line);
    if (!numbers && rows == 0 && !names_seen) {
      names_seen = true;
      continue;
    }
    // The row at the end of the head may be cut off.
    if (cut && numbers && rows > 0 && numbers->size() < columns && &whole == &lines.back()) continue;
    if (!numbers || (rows > 0 && numbers->size() != columns)) return MeasuredFormat::kAuto;
    columns = numbers->size();
    const double first = numbers->front();
    // Points x, y, height along a row of the map: x ascends, y stays.
    if (columns == 3 && rows > 0) same_second = same_second && (*numbers)[1] == second;
    if (columns == 3) second = (*numbers)[1];
    if (rows > 0) {
      ascending = ascending && first > before;
      descending = descending && first < before;
    }
    before = first;
    ++rows;
  }
  if (rows == 0 || columns < 2) return MeasuredFormat::kAuto;
  if (map_key) return MeasuredFormat::kMapText;
  if (profile_key || columns == 2) return MeasuredFormat::kProfileText;
  if (columns == 3 && same_second) return MeasuredFormat::kMapText;
  return rows > 1 && (ascending || descending) ? MeasuredFormat::kProfileText : MeasuredFormat::kMapText;
}

}  // namespace

MeasuredFormat detect_format(const std::string& path) {
  const std::optional<std::string> head = file_bytes(path, kHead);
  if (head)
    if (const MeasuredFormat format = format_of_magic(*head); format != MeasuredFormat::kAuto) return format;
  if (is_dabam(path, head)) return MeasuredFormat::kDabam;
  if (!head)
    throw InputError(path, "", "a file that cannot be opened", "the name of a file that can be read");
  if (head->find('\0') != std::string::npos) return MeasuredFormat::kAuto;
  const std::vector<std::string_view> lines = lines_of(*head);
  if (is_codev_int(lines)) return MeasuredFormat::kCodeVInt;
  if (is_zemax_grid_sag(lines)) return MeasuredFormat::kZemaxGridSag;
  return columns_format(lines, head->size() == kHead);
}

const std::vector<std::string>& measured_format_names() {
  static const std::vector<std::string> names = {"auto", "dabam",     "profile", "map",
                                                 "zygo", "codev-int", "fits",    "zemax-grid-sag",
                                                 "datx", "opd",       "sdf",     "x3p"};
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
