#pragma once
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/measured/read_measurement.h"
#include "file_options.h"

// What the readers of height maps share: bytes, lines, numbers and the options that every map has.

namespace aberfit::internal {

/// Most points a map may have; more is a damaged header or no job for this program.
inline constexpr std::int64_t kMostMapPoints = 1'000'000'000;

/// The whole file. Throws InputError when it is no readable regular file.
inline std::string read_map_bytes(const std::string& path) {
  std::error_code problem;
  const auto status = std::filesystem::status(path, problem);
  if (!std::filesystem::exists(status)) throw InputError(path, "", "no such file", "a readable file");
  // A device or a pipe has no size to bound what is read from it.
  if (!std::filesystem::is_regular_file(status))
    throw InputError(path, "", "something that is not a file", "a readable file");
  std::ifstream file(path, std::ios::binary);
  const auto size = std::filesystem::file_size(path, problem);
  std::string bytes;
  if (file && !problem) {
    bytes.resize(std::size_t(size));
    file.read(bytes.data(), std::streamsize(size));
    bytes.resize(std::size_t(file.gcount()));
  }
  if (problem || bytes.size() != size)
    throw InputError(path, "", "a file that cannot be read", "a readable file");
  return bytes;
}

/// A short quotation of a damaged file, safe to print on one line.
inline std::string quoted(std::string_view text) {
  constexpr std::size_t kMost = 40;
  std::string clean = "\"";
  for (const char c : text.substr(0, kMost)) clean += c >= 0x20 && c < 0x7f ? c : '?';
  return clean + (text.size() > kMost ? "...\"" : "\"");
}

/// One line of text for a file of 7-bit text: other characters become spaces, the ends are trimmed.
inline std::string one_line(std::string_view text, std::size_t most) {
  std::string clean;
  for (const char c : text) clean += c >= 0x20 && c < 0x7f ? c : ' ';
  clean.erase(0, std::min(clean.find_first_not_of(' '), clean.size()));
  clean.resize(std::min(clean.size(), most));
  clean.erase(clean.find_last_not_of(' ') + 1);
  return clean;
}

/// Words of a line, separated by blanks and control characters (which covers CR and the Ctrl-Z of DOS).
inline std::vector<std::string_view> words(std::string_view line) {
  std::vector<std::string_view> found;
  const auto blank = [](char c) { return static_cast<unsigned char>(c) <= 0x20; };
  for (std::size_t i = 0; i < line.size();) {
    while (i < line.size() && blank(line[i])) ++i;
    const std::size_t begin = i;
    while (i < line.size() && !blank(line[i])) ++i;
    if (i > begin) found.push_back(line.substr(begin, i - begin));
  }
  return found;
}

/// The number that is the whole word, or nothing; never infinite, never NaN.
template <class Number>
std::optional<Number> number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  if (word.starts_with('+')) return std::nullopt;
  Number value{};
  const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (problem != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  if constexpr (std::is_floating_point_v<Number>)
    if (!std::isfinite(value)) return std::nullopt;
  return value;
}

/// Lines of a text, ended by LF, CR LF or CR, counted from 1.
class LineReader {
 public:
  explicit LineReader(std::string_view text) : rest_(text) {}
  /// The next line without its end; false at the end of the text.
  bool next(std::string_view* line) {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find_first_of("\r\n");
    *line = rest_.substr(0, end);
    ++number_;
    if (end == std::string_view::npos) {
      rest_ = {};
    } else {
      const bool two = rest_[end] == '\r' && end + 1 < rest_.size() && rest_[end + 1] == '\n';
      rest_.remove_prefix(end + (two ? 2 : 1));
    }
    return true;
  }
  /// The next line that is neither blank nor a comment ('!').
  bool next_with_content(std::string_view* line) {
    while (next(line)) {
      const auto found = words(*line);
      if (!found.empty() && found[0][0] != '!') return true;
    }
    return false;
  }
  std::string place() const { return "line " + std::to_string(number_); }
  std::size_t bytes_left() const { return rest_.size(); }

 private:
  std::string_view rest_;
  std::int64_t number_ = 0;
};

/// An option that must be a positive finite number, if it is given.
inline void require_positive(const std::string& path, const char* name, std::optional<double> value) {
  if (value && !(*value > 0 && std::isfinite(*value)))
    throw InputError(path, "option '" + std::string(name) + "'", std::to_string(*value), "a positive number");
}
inline void require_sane_options(const MeasuredSource& source) {
  require_positive(source.path, "pitch", source.pitch);
  require_positive(source.path, "wavelength", source.wavelength);
  if (source.value_factor && !(std::isfinite(*source.value_factor) && *source.value_factor != 0))
    throw InputError(source.path, "option 'value_unit'", std::to_string(*source.value_factor),
                     "a finite number other than 0");
}

/// What heights are multiplied by to be those of the surface: light reflected at normal incidence goes over
/// every height twice.
inline double surface_per_height(bool wavefront) { return wavefront ? 0.5 : 1.0; }

/// A map of invalid points with its origin in the middle; pitch 0 means unknown.
inline HeightMap empty_map(Eigen::Index rows, Eigen::Index columns, double pitch_x, double pitch_y) {
  HeightMap map;
  map.height = Grid::Constant(rows, columns, std::numeric_limits<double>::quiet_NaN());
  map.pitch_x = pitch_x;
  map.pitch_y = pitch_y;
  centre_on_grid(&map);
  return map;
}

}  // namespace aberfit::internal
