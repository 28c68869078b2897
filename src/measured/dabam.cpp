// DABAM, the database of X-ray mirror profiles: Sanchez del Rio et al. 2016, J. Synchrotron Rad. 23, 665.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "aberfit/core/errors.h"
#include "aberfit/measured/read_measurement.h"
#include "text_columns.h"
#include "text_columns_names.h"
#include "text_columns_profile.h"

namespace aberfit {
using namespace internal;

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kFactorAllowed = "a finite number other than 0 that converts to m or rad";

struct Paths {
  std::string metadata, data;
};

Paths paths_of(const std::string& path) {
  const std::string suffix = lower_case(fs::path(path).extension().string());
  const std::string stem = suffix == ".txt" || suffix == ".dat" ? path.substr(0, path.size() - 4) : path;
  Paths paths{stem + ".txt", stem + ".dat"};
  if (suffix == ".txt") paths.metadata = path;
  if (suffix == ".dat") paths.data = path;
  return paths;
}

Json read_metadata(const std::string& path) {
  constexpr std::size_t kLargest = std::size_t(1) << 20;
  const char* const allowed = "JSON metadata of DABAM, an object with FILE_FORMAT";
  const std::optional<std::string> bytes = file_bytes(path, kLargest + 1);
  if (!bytes) throw InputError(path, "", "a file that cannot be opened", allowed);
  const std::string& text = *bytes;
  if (text.size() > kLargest)
    throw InputError(path, "", fmt::format("more than {} bytes", kLargest), allowed);
  try {
    Json metadata = Json::parse(text);
    if (!metadata.is_object())
      throw InputError(path, "", std::string("JSON ") + metadata.type_name(), allowed);
    return metadata;
  } catch (const Json::parse_error& error) {
    const std::size_t byte = std::min(error.byte, text.size());
    const long line = 1 + std::count(text.begin(), text.begin() + std::ptrdiff_t(byte), '\n');
    const std::size_t begin = text.rfind('\n', byte == 0 ? 0 : byte - 1);
    const std::string_view rest = std::string_view(text).substr(begin == std::string::npos ? 0 : begin + 1);
    fail_at_line(path, line, in_quotes(rest.substr(0, rest.find_first_of("\r\n"))), allowed);
  } catch (const Json::exception&) {  // a number outside the range of a double
    throw InputError(path, "", "JSON with a number beyond the range of a double", allowed);
  }
}

// In DABAM files a value may be a number, a string with a number, "" or null.
class Metadata {
 public:
  explicit Metadata(const std::string& path) : path_(path), json_(read_metadata(path)) {}

  std::optional<double> number(const std::string& key) const {
    const auto found = json_.find(key);
    if (found == json_.end() || found->is_null()) return std::nullopt;
    if (found->is_number()) return found->get<double>();
    if (found->is_string()) {
      const std::string text = lower_case(trimmed(found->get_ref<const std::string&>()));
      if (text.empty() || text == "null" || text == "none") return std::nullopt;
      const std::optional<double> value = parse_cell(text);
      if (value && std::isfinite(*value)) return value;
    }
    fail(key, "a number");
  }

  std::optional<long> integer(const std::string& key, long lowest, long highest, const char* allowed) const {
    const std::optional<double> value = number(key);
    if (!value) return std::nullopt;
    if (!(*value >= double(lowest) && *value <= double(highest)) || *value != std::floor(*value))
      fail(key, allowed);
    return long(*value);
  }

  std::string text(const std::string& key) const {
    const auto found = json_.find(key);
    if (found == json_.end() || !found->is_string()) return "";
    return found->get<std::string>();
  }

  bool says(const std::string& key) const {
    const auto found = json_.find(key);
    if (found == json_.end() || found->is_null()) return false;
    return !found->is_string() || !found->get_ref<const std::string&>().empty();
  }

  [[noreturn]] void fail(const std::string& key, const std::string& allowed) const {
    const auto found = json_.find(key);
    using Handler = Json::error_handler_t;
    const std::string shown =
        found == json_.end() ? "nothing" : in_quotes(found->dump(-1, ' ', false, Handler::replace));
    throw InputError(path_, "/" + key, shown, allowed);
  }

  const std::string& path() const { return path_; }

 private:
  std::string path_;
  Json json_;
};

// X1_FACTOR is required; X2_FACTOR and so on default to it. Factors of positions must be positive: with a
// mirrored axis it would be unclear whether the slopes are mirrored, too.
double axis_factor(const Metadata& metadata, char axis, std::size_t scan) {
  const std::string first = fmt::format("{}1_FACTOR", axis);
  std::string key = fmt::format("{}{}_FACTOR", axis, scan);
  if (!metadata.says(key)) key = first;
  const std::optional<double> factor = metadata.number(key);
  if (!factor || !std::isfinite(*factor) || *factor == 0) metadata.fail(key, kFactorAllowed);
  if (axis == 'X' && *factor < 0) metadata.fail(key, "a factor above zero");
  return *factor;
}

// The properties of a plot title that distinguish scan lines.
struct Title {
  std::optional<ProfileQuantity> quantity;
  bool residual = false;
  bool operator==(const Title&) const = default;
};

Title title_of(const std::string& text) {
  return {quantity_of_word(text), lower_case(text).find("residual") != std::string::npos};
}

// A further column is a scan line only if the metadata describe it as the same quantity. In dabam-010, for
// example, residual height and two slopes of the same scan follow.
bool is_further_scan(const Metadata& metadata, std::size_t scan, ProfileQuantity quantity) {
  const std::string title_key = fmt::format("PLOT_TITLE_Y{}", scan);
  if (metadata.says(title_key)) {
    const Title first =
        metadata.says("PLOT_TITLE_Y1") ? title_of(metadata.text("PLOT_TITLE_Y1")) : Title{quantity, false};
    return title_of(metadata.text(title_key)) == first;
  }
  return metadata.says(fmt::format("Y{}_FACTOR", scan)) &&
         axis_factor(metadata, 'Y', scan) == axis_factor(metadata, 'Y', 1);
}

std::string label_of(const Metadata& metadata, std::size_t scan) {
  std::string label = fs::path(metadata.path()).stem().string();
  for (const std::string& key : {std::string("USER_REFERENCE"), fmt::format("PLOT_TITLE_Y{}", scan)})
    if (const std::string text = metadata.text(key); !text.empty()) label += ", " + text;
  return label;
}

}  // namespace

std::vector<Profile> read_dabam(const std::string& path) {
  const Paths paths = paths_of(path);
  const Metadata metadata(paths.metadata);
  const char* const formats = "1 (slope), 2 (height), 3 (pairs of x and slope) or 4 (pairs of x and height)";
  const std::optional<long> format = metadata.integer("FILE_FORMAT", 1, 4, formats);
  if (!format) metadata.fail("FILE_FORMAT", formats);
  TextRules rules;
  rules.plain = true;
  rules.skip_lines =
      metadata.integer("FILE_HEADER_LINES", 0, 1000000, "a number of lines, 0 or more").value_or(0);
  const char* const indices = "a column, counted from 0";
  const long x_index = metadata.integer("COLUMN_INDEX_ABSCISSAS", 0, 1000, indices).value_or(0);
  const long y_index = metadata.integer("COLUMN_INDEX_ORDINATES", 0, 1000, indices).value_or(1);
  if (x_index == y_index)
    metadata.fail("COLUMN_INDEX_ORDINATES", "a column other than that of the abscissas");

  const TextTable table = read_text_table(paths.data, rules);
  const std::size_t needed = std::size_t(std::max(x_index, y_index)) + 1;
  if (table.columns < needed)
    fail_at_line(table.path, table.lines.front(), fmt::format("{} columns", table.columns),
                 fmt::format("at least {} columns, as the metadata say", needed));

  ProfileColumns columns;
  columns.x = std::size_t(x_index);
  columns.value = std::size_t(y_index);
  columns.quantity = *format % 2 == 1 ? ProfileQuantity::kSlope : ProfileQuantity::kHeight;
  std::vector<Profile> profiles;
  const auto add = [&](std::size_t scan) {
    columns.x_factor = axis_factor(metadata, 'X', scan);
    columns.value_factor = axis_factor(metadata, 'Y', scan);
    profiles.push_back(profile_of(table, columns));
    profiles.back().label = label_of(metadata, scan);
  };
  add(1);
  // If the metadata name columns other than the first two, only these are read.
  if (x_index != 0 || y_index != 1) return profiles;
  const bool pairs = *format >= 3;
  if (pairs && table.columns % 2 != 0)
    fail_at_line(table.path, table.lines.front(), fmt::format("{} columns", table.columns),
                 "pairs of columns, as FILE_FORMAT says");
  const std::size_t scans = pairs ? table.columns / 2 : table.columns - 1;
  for (std::size_t scan = 2; scan <= scans; ++scan) {
    if (!pairs && !is_further_scan(metadata, scan, columns.quantity)) continue;
    columns.x = pairs ? 2 * scan - 2 : 0;
    columns.value = pairs ? 2 * scan - 1 : scan;
    add(scan);
  }
  return profiles;
}

}  // namespace aberfit
