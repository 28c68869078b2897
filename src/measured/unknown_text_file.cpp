#include "unknown_text_file.h"

#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "text_columns.h"

namespace aberfit::internal {
namespace {

constexpr std::size_t kHeadOfText = 8192;

// True for a line meant as numbers: its first field is a number, possibly with a decimal comma.
bool begins_with_number(std::string_view line) {
  std::vector<std::string_view> fields;
  split(line, delimiter_of(line), &fields);
  return decimal_comma(line) || (!fields.empty() && !fields.front().empty() && parse_cell(fields.front()));
}

}  // namespace

void refuse_unknown_text(const MeasuredSource& source) {
  const std::optional<std::string> bytes = file_bytes(source.path, kHeadOfText);
  if (!bytes) return;
  std::string head = utf8_text(*bytes);
  if (head.starts_with("\xef\xbb\xbf")) head.erase(0, 3);
  if (head.find('\0') != std::string::npos) return;
  const std::string formats = "a file of format " + measured_format_list();
  if (trimmed(head).empty()) throw InputError(source.path, "", "an empty file", formats);
  bool any = false;
  for (const std::string_view line : words(head, "\r\n"))
    any = any || (!line.starts_with('#') && begins_with_number(line));
  if (!any) throw InputError(source.path, "", "text without a row of numbers", formats);
  read_text_table(source.path, {});  // throws for the line that is not a row of numbers
}

}  // namespace aberfit::internal
