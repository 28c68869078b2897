#include "text_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>

#include "aberfit/core/errors.h"

namespace aberfit::internal {
namespace {

constexpr const char* kBlanks = " \t\v\f";
constexpr const char* kTextAllowed = "a text file of numbers in columns (ASCII or UTF-8)";

// Names of a row that is no row of numbers: none of them may be a number.
bool all_names(std::string_view line) {
  std::vector<std::string_view> fields;
  split(line, delimiter_of(line), &fields);
  bool name = false;
  for (const std::string_view field : fields) {
    if (trimmed(field).empty()) continue;
    if (parse_cell(field)) return false;
    name = true;
  }
  return name;
}

// Splits at the delimiter of the numbers, then at others, until the count fits; a unit in brackets behind a
// blank belongs to the word before it.
std::vector<std::string> names_for(const std::string& line, char delimiter, std::size_t columns) {
  std::vector<std::string_view> fields;
  for (const char candidate : {delimiter, ';', '\t', ',', ' '}) {
    split(line, candidate, &fields);
    std::vector<std::string> names;
    for (const std::string_view field : fields) {
      const std::string_view name = trimmed(field);
      const bool unit =
          candidate == ' ' && !names.empty() && !name.empty() && (name[0] == '(' || name[0] == '[');
      if (unit)
        names.back() += " " + std::string(name);
      else
        names.emplace_back(name);
    }
    if (names.size() == columns) return names;
  }
  return {};
}

void drop_last_column(TextTable* table) {
  const std::size_t rows = table->rows(), columns = table->columns;
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t column = 0; column + 1 < columns; ++column)
      table->values[row * (columns - 1) + column] = table->values[row * columns + column];
  table->columns = columns - 1;
  table->values.resize(rows * table->columns);
}

}  // namespace

TextLines::TextLines(const std::string& path, const TextLimits& limits)
    : path_(path), limits_(limits), buffer_(std::size_t(1) << 16) {
  std::error_code error;
  // A pipe could block and a folder opens without an error: only files.
  if (!std::filesystem::is_regular_file(path, error))
    throw InputError(path, "", "no file", "the name of a file that can be read");
  file_.open(path, std::ios::binary);
  if (!file_)
    throw InputError(path, "", "a file that cannot be opened", "the name of a file that can be read");
  if (!fill()) return;
  const std::string_view head(buffer_.data(), end_);
  if (head.starts_with("\xff\xfe") || head.starts_with("\xfe\xff"))
    throw InputError(path, "", "UTF-16 text", kTextAllowed);
  if (head.starts_with("\xef\xbb\xbf")) begin_ = 3;
}

bool TextLines::fill() {
  file_.read(buffer_.data(), std::streamsize(buffer_.size()));
  begin_ = 0;
  end_ = std::size_t(file_.gcount());
  if (file_.bad()) throw InputError(path_, "", "a file that cannot be read to its end", kTextAllowed);
  return end_ > 0;
}

bool TextLines::next(std::string_view* line) {
  line_.clear();
  for (bool any = false;; any = true) {
    if (begin_ == end_ && !fill()) {
      if (!any || line_.empty()) return false;
      break;
    }
    // The LF of a CR LF whose CR ended the line before.
    if (after_return_ && buffer_[begin_] == '\n') ++begin_;
    after_return_ = false;
    const auto first = buffer_.begin() + std::ptrdiff_t(begin_),
               last = buffer_.begin() + std::ptrdiff_t(end_);
    const auto stop = std::find_if(first, last, [](char c) { return c == '\n' || c == '\r' || c == '\0'; });
    line_.append(first, stop);
    if (line_.size() > limits_.line_length)
      fail_at_line(path_, number_ + 1, fmt::format("more than {} characters", limits_.line_length),
                   "shorter lines of numbers");
    begin_ = std::size_t(stop - buffer_.begin());
    if (stop == last) continue;
    if (*stop == '\0')
      fail_at_line(path_, number_ + 1, "a byte that is zero, as in a binary file", kTextAllowed);
    after_return_ = *stop == '\r';
    ++begin_;
    break;
  }
  ++number_;
  *line = line_;
  return true;
}

void fail_at_line(const std::string& path, long line, const std::string& found, const std::string& allowed) {
  throw InputError(path, fmt::format("line {}", line), found, allowed);
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string shown = "'";
  for (const char c : text.substr(0, kLongest)) shown += c >= ' ' && c <= '~' ? c : '?';
  return shown + (text.size() > kLongest ? "...'" : "'");
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return lower;
}

char delimiter_of(std::string_view line) {
  for (const char candidate : {';', '\t', ','})
    if (line.find(candidate) != std::string_view::npos) return candidate;
  return ' ';
}

void split(std::string_view line, char delimiter, std::vector<std::string_view>* fields) {
  fields->clear();
  if (delimiter == ' ') {
    for (std::size_t begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;) {
      const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
      fields->push_back(line.substr(begin, end - begin));
      begin = line.find_first_not_of(kBlanks, end);
    }
    return;
  }
  for (std::size_t begin = 0;;) {
    const std::size_t end = line.find(delimiter, begin);
    fields->push_back(trimmed(line.substr(begin, end - begin)));
    if (end == std::string_view::npos) return;
    begin = end + 1;
  }
}

std::optional<double> parse_cell(std::string_view text) {
  constexpr double kHole = std::numeric_limits<double>::quiet_NaN();
  text = trimmed(text);
  if (text.empty() || text == "--") return kHole;
  std::string_view digits = text;
  if (digits.front() == '+') digits.remove_prefix(1);
  if (digits.empty() || digits.front() == '+') return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || digits.starts_with("+-"))
    return std::nullopt;
  return std::isnan(value) ? kHole : value;
}

const std::vector<std::string>& known_text_keys() {
  static const std::vector<std::string> keys = {"of",       "pitch",      "unit",   "x_unit",
                                                "quantity", "wavelength", "layout", "label"};
  return keys;
}

std::optional<std::pair<std::string, std::string>> comment_key(std::string_view line) {
  line.remove_prefix(std::min(line.find_first_not_of("# \t"), line.size()));
  const std::size_t sign = line.find_first_of("=:");
  if (sign == std::string_view::npos) return std::nullopt;
  const std::string key = lower_case(trimmed(line.substr(0, sign)));
  const auto& known = known_text_keys();
  if (std::find(known.begin(), known.end(), key) == known.end()) return std::nullopt;
  return std::pair(key, std::string(trimmed(line.substr(sign + 1))));
}

TextTable read_text_table(const std::string& path, const TextRules& rules) {
  TextLines lines(path, rules.limits);
  TextTable table;
  table.path = path;
  std::string_view line;
  for (long i = 0; i < rules.skip_lines; ++i)
    if (!lines.next(&line))
      throw InputError(path, "", fmt::format("the end of the file after {} lines", lines.number()),
                       fmt::format("rows of numbers after {} header lines", rules.skip_lines));

  std::string name_row, last_comment;
  std::vector<std::string_view> fields;
  char delimiter = ' ';
  bool last_column_used = false;
  while (lines.next(&line)) {
    if (const std::size_t hash = line.find('#'); hash != std::string_view::npos) {
      if (trimmed(line.substr(0, hash)).empty()) {
        const auto key = rules.plain ? std::nullopt : comment_key(line);
        if (key && !table.keys.emplace(key->first, TextKey{key->second, lines.number()}).second)
          fail_at_line(path, lines.number(), in_quotes(line),
                       fmt::format("'{}' said once, as in line {}", key->first, table.keys[key->first].line));
        if (table.lines.empty() && !key) last_comment = line.substr(hash + 1);
        continue;
      }
      line = line.substr(0, hash);
    }
    if (trimmed(line).empty()) continue;
    if (table.lines.empty()) {
      if (!rules.plain && name_row.empty() && all_names(line)) {
        name_row = line;
        continue;
      }
      delimiter = rules.plain ? ' ' : delimiter_of(line);
    }
    split(line, delimiter, &fields);
    if (table.lines.empty()) table.columns = fields.size();
    const std::size_t first = table.values.size();
    if (first + fields.size() > rules.limits.numbers)
      fail_at_line(path, lines.number(), fmt::format("more than {} numbers", rules.limits.numbers),
                   "a smaller file");
    for (const std::string_view field : fields) {
      const std::optional<double> value = parse_cell(field);
      if (!value) fail_at_line(path, lines.number(), in_quotes(field), "a number a double can hold");
      if (std::isinf(*value))
        fail_at_line(path, lines.number(), in_quotes(field), "a finite number, or 'nan' or '--' for a hole");
      table.values.push_back(*value);
    }
    if (fields.size() != table.columns)
      fail_at_line(path, lines.number(), fmt::format("{} columns", fields.size()),
                   fmt::format("{} columns, as in line {}", table.columns, table.lines.front()));
    last_column_used = last_column_used || !fields.back().empty();
    table.lines.push_back(lines.number());
  }
  if (table.lines.empty()) throw InputError(path, "", "no row of numbers", kTextAllowed);
  // A delimiter at the end of every line makes an empty column.
  if (!last_column_used && table.columns > 1) drop_last_column(&table);
  if (name_row.empty()) name_row = last_comment;
  table.names = names_for(name_row, delimiter, table.columns);
  return table;
}

}  // namespace aberfit::internal
