#include "text_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/measured/read_measurement.h"

namespace aberfit::internal {
namespace {

constexpr const char* kNumbersAllowed = "a text file of numbers in columns (ASCII, UTF-8 or UTF-16)";

// True if the fields of a row are names, none of them a number.
bool all_names(std::string_view line) {
  if (decimal_comma(line)) return false;
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

// Splits at the delimiter of the numbers, then at others, until the count fits. A unit in brackets after a
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

// Like `split`, for a line with double quotes: quoted text is one field, or part of one.
void split_quoted(std::string_view line, char delimiter, std::vector<std::string_view>* fields) {
  fields->clear();
  const auto add = [&](std::string_view field) {
    field = trimmed(field);
    if (delimiter == ' ' && field.empty()) return;
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"')
      field = trimmed(field.substr(1, field.size() - 2));
    fields->push_back(field);
  };
  std::size_t begin = 0;
  bool inside = false;
  for (std::size_t at = 0; at < line.size(); ++at) {
    if (line[at] == '"') inside = !inside;
    const bool blank = delimiter == ' ' && kBlanks.find(line[at]) != std::string_view::npos;
    if (inside || !(blank || line[at] == delimiter)) continue;
    add(line.substr(begin, at - begin));
    begin = at + 1;
  }
  add(line.substr(begin));
}

// Returns the field without brackets if it is a unit that a column may have, otherwise nothing.
std::string_view unit_alone(std::string_view field) {
  std::string_view unit = trimmed(field);
  if (unit.size() > 2 &&
      ((unit.front() == '[' && unit.back() == ']') || (unit.front() == '(' && unit.back() == ')')))
    unit = trimmed(unit.substr(1, unit.size() - 2));
  if (is_waves(unit)) return unit;
  for (const Dimension dimension : {Dimension::kLength, Dimension::kAngle, Dimension::kFraction}) {
    try {
      if (!unit.empty()) unit_factor(unit, dimension);
      return unit;
    } catch (const UnitError&) {
    }
  }
  return {};
}

// "X;Z" above "[mm];[nm]" give the names "X [mm]" and "Z [nm]".
void add_units(const std::vector<std::string>& units, std::vector<std::string>* names) {
  if (units.empty()) return;
  names->resize(units.size());
  for (std::size_t i = 0; i < units.size(); ++i)
    if (const std::string_view unit = unit_alone(units[i]); !unit.empty())
      (*names)[i] += fmt::format(" [{}]", unit);
}

[[noreturn]] void refuse_cell(const TextLines& lines, std::string_view line, std::string_view field,
                              const TextTable& table, bool names_seen) {
  if (const auto comma = decimal_comma(line))
    lines.fail(in_quotes(*comma) + ", a decimal comma", kDecimalPoint);
  // A row of words is quoted as a whole in the message, because its first word alone explains little.
  const bool text = all_names(line);
  lines.fail(
      in_quotes(text ? trimmed(line) : field),
      std::string("a number a double can hold") +
          (!table.lines.empty() ? "; '#' begins a line that is no row of numbers"
           : names_seen
               ? "; before the numbers one line may have names and the next one units; others begin with '#'"
               : ""));
}

void drop_last_column(TextTable* table) {
  const std::size_t rows = table->rows(), columns = table->columns;
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t column = 0; column + 1 < columns; ++column)
      table->values[row * (columns - 1) + column] = table->values[row * columns + column];
  table->columns = columns - 1;
  table->values.resize(rows * table->columns);
}

// Forms rows of `length` numbers, regardless of the line ends.
void wrap_rows(std::size_t length, TextTable* table) {
  const std::size_t numbers = table->values.size();
  if (numbers % length != 0)
    throw InputError(table->path, "option 'columns'",
                     fmt::format("{} numbers in the file, {} rows of {} and {} more", numbers,
                                 numbers / length, length, numbers % length),
                     "the number of samples in a row, a divisor of their total number");
  table->columns = length;
  // Line numbers are used in messages only, and rows may share a line.
  table->lines.resize(numbers / length, table->lines.back());
}

}  // namespace

char delimiter_of(std::string_view line) {
  const bool quotes = line.find('"') != std::string_view::npos;
  for (const char candidate : {';', '\t', ','}) {
    if (!quotes && line.find(candidate) != std::string_view::npos) return candidate;
    bool inside = false;
    for (std::size_t at = 0; quotes && at < line.size(); ++at) {
      if (line[at] == '"') inside = !inside;
      if (line[at] == candidate && !inside) return candidate;
    }
  }
  return ' ';
}

bool is_unit_row(std::string_view line) {
  std::vector<std::string_view> fields;
  split(line, delimiter_of(line), &fields);
  bool any = false;
  for (const std::string_view field : fields) {
    if (field.empty()) continue;
    if (parse_cell(field) || unit_alone(field).empty()) return false;
    any = true;
  }
  return any;
}

void split(std::string_view line, char delimiter, std::vector<std::string_view>* fields) {
  if (line.find('"') != std::string_view::npos) return split_quoted(line, delimiter, fields);
  if (delimiter == ' ') return find_words(line, kBlanks, fields);
  fields->clear();
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
  const std::optional<double> value = parse_number<double>(text);
  return value && std::isnan(*value) ? kHole : value;
}

const std::vector<std::string>& known_text_keys() {
  static const std::vector<std::string> keys = {"of",       "pitch",      "unit",   "x_unit",
                                                "quantity", "wavelength", "layout", "label",
                                                "channel",  "width",      "height", "value units"};
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
  TextLines lines(path);
  TextTable table;
  table.path = path;
  std::string_view line;
  for (long i = 0; i < rules.skip_lines; ++i)
    if (!lines.next(&line))
      throw InputError(path, "", fmt::format("the end of the file after {} lines", lines.number()),
                       fmt::format("rows of numbers after {} header lines", rules.skip_lines));

  std::string name_row, unit_row, last_comment;
  std::vector<std::string_view> fields;
  char delimiter = ' ';
  bool last_column_used = false;
  while (lines.next(&line)) {
    if (const std::string_view content = before_comment(line); content.size() < line.size()) {
      if (trimmed(content).empty()) {
        const auto key = rules.plain ? std::nullopt : comment_key(line);
        if (key && !table.keys.emplace(key->first, TextKey{key->second, lines.number()}).second)
          lines.fail(in_quotes(line),
                     fmt::format("'{}' only once, as in line {}", key->first, table.keys[key->first].line));
        if (table.lines.empty() && !key) last_comment = line.substr(content.size() + 1);
        continue;
      }
      line = content;
    }
    if (trimmed(line).empty()) continue;
    if (table.lines.empty()) {
      if (!rules.plain && name_row.empty() && all_names(line)) {
        name_row = line;
        continue;
      }
      if (!name_row.empty() && unit_row.empty() && is_unit_row(line)) {
        unit_row = line;
        continue;
      }
      delimiter = rules.plain ? ' ' : delimiter_of(line);
    }
    split(line, delimiter, &fields);
    if (table.lines.empty()) table.columns = fields.size();
    const std::size_t first = table.values.size();
    if (first + fields.size() > rules.most_numbers)
      lines.fail(fmt::format("more than {} numbers", rules.most_numbers), "a smaller file");
    for (const std::string_view field : fields) {
      const std::optional<double> value = parse_cell(field);
      if (!value) refuse_cell(lines, line, field, table, !name_row.empty());
      if (std::isinf(*value)) lines.fail(in_quotes(field), "a finite number, or 'nan' or '--' for a hole");
      table.values.push_back(*value);
    }
    // If rows extend over lines, a delimiter at the end of a line adds no field.
    if (rules.row_length > 0 && fields.size() > 1 && fields.back().empty()) table.values.pop_back();
    if (fields.size() != table.columns && rules.row_length == 0)
      lines.fail(fmt::format("{} columns", fields.size()),
                 fmt::format("{} columns, as in line {}", table.columns, table.lines.front()));
    last_column_used = last_column_used || !fields.back().empty();
    table.lines.push_back(lines.number());
  }
  if (table.lines.empty()) throw InputError(path, "", "no row of numbers", kNumbersAllowed);
  if (rules.row_length > 0) {
    wrap_rows(rules.row_length, &table);
    return table;
  }
  // A delimiter at the end of every line creates an empty column.
  if (!last_column_used && table.columns > 1) drop_last_column(&table);
  if (name_row.empty()) name_row = last_comment;
  table.names = names_for(name_row, delimiter, table.columns);
  if (!unit_row.empty()) add_units(names_for(unit_row, delimiter, table.columns), &table.names);
  return table;
}

}  // namespace aberfit::internal
