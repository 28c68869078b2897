// NumPy .npy: one array, its header a Python dictionary (numpy/lib/format.py, versions 1 to 3).
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr std::string_view kNpyMagic = "\x93NUMPY";

struct NpyHeader {
  std::string type;  // "<f8"
  bool fortran_order = false;
  std::vector<std::int64_t> shape;
  std::uint64_t data = 0;  // position of the first value in bytes
};

// Returns the text after `'key':` in the dictionary up to its end; a tuple includes its brackets.
std::string_view npy_entry(const std::string& path, std::string_view dictionary, std::string_view key) {
  for (const char quote : {'\'', '"'}) {
    const std::string quoted = quote + std::string(key) + quote;
    const std::size_t at = dictionary.find(quoted);
    if (at == std::string_view::npos) continue;
    const std::string_view rest = trimmed(dictionary.substr(at + quoted.size()));
    if (!rest.starts_with(':')) continue;
    const std::string_view value = trimmed(rest.substr(1));
    const std::size_t end = value.starts_with('(') ? value.find(')') : value.find_first_of(",}");
    if (end == std::string_view::npos) break;
    return value.starts_with('(') ? value.substr(1, end - 1) : trimmed(value.substr(0, end));
  }
  throw InputError(path, fmt::format("header, '{}'", key), "nothing",
                   "a dictionary of 'descr', 'fortran_order' and 'shape', as numpy.save writes it");
}

NpyHeader npy_header(const std::string& path, const FileBytes& file) {
  if (!file.holds(0, 10) || file.text(0, kNpyMagic.size()) != kNpyMagic)
    file.fail(0, "other bytes", "a .npy file, which begins with the byte 0x93 and NUMPY");
  const unsigned version = file.at<std::uint8_t>(6);
  if (version < 1 || version > 3) file.fail(6, fmt::format("version {}", version), "1 to 3");
  const std::uint64_t begin = version == 1 ? 10 : 12;
  const std::uint64_t length =
      version == 1 ? file.at<std::uint16_t>(8) : std::uint64_t(file.at<std::uint32_t>(8));
  const std::string_view dictionary = file.text(begin, length);
  NpyHeader header;
  header.data = begin + length;
  const std::string_view type = npy_entry(path, dictionary, "descr");
  header.type = one_line(type.size() < 2 ? type : type.substr(1, type.size() - 2), 20);
  if (!type.starts_with('\'') && !type.starts_with('"')) header.type = one_line(type, 40);
  const std::string_view order = npy_entry(path, dictionary, "fortran_order");
  if (order != "True" && order != "False")
    throw InputError(path, "header, 'fortran_order'", in_quotes(order.substr(0, 40)), "True or False");
  header.fortran_order = order == "True";
  for (const std::string_view size : words(npy_entry(path, dictionary, "shape"), ", ")) {
    const auto number =
        parse_number<std::int64_t>(size.ends_with('L') ? size.substr(0, size.size() - 1) : size);
    if (!number || *number < 0)
      throw InputError(path, "header, 'shape'", in_quotes(size.substr(0, 40)), "whole numbers from 0 on");
    header.shape.push_back(*number);
  }
  return header;
}

using NpyRead = double (*)(const FileBytes& file, std::uint64_t place);
struct NpyType {
  std::uint64_t bytes = 0;
  NpyRead read = nullptr;
};
template <class Number>
NpyType npy_number() {
  return {sizeof(Number),
          [](const FileBytes& file, std::uint64_t place) { return double(file.at<Number>(place)); }};
}

// Returns the number type; the first character of `type` is the byte order.
NpyType npy_type(const std::string& path, const std::string& type) {
  const std::string kind = type.substr(std::min<std::size_t>(1, type.size()));
  const bool ordered = type.starts_with('<') || type.starts_with('>');
  if (ordered && kind == "f8") return npy_number<double>();
  if (ordered && kind == "f4") return npy_number<float>();
  if (ordered && kind == "i2") return npy_number<std::int16_t>();
  if (ordered && kind == "u2") return npy_number<std::uint16_t>();
  if (ordered && kind == "i4") return npy_number<std::int32_t>();
  if (ordered && kind == "u4") return npy_number<std::uint32_t>();
  if (ordered && kind == "i8") return npy_number<std::int64_t>();
  if (ordered && kind == "u8") return npy_number<std::uint64_t>();
  if (kind == "i1") return npy_number<std::int8_t>();
  if (kind == "u1") return npy_number<std::uint8_t>();
  throw InputError(path, "header, 'descr'", in_quotes(type),
                   "f4, f8 or integers of 1 to 8 bytes, such as <f8 (array.astype(float) converts to it)");
}

// Returns the chosen plane of a cube (planes, rows, columns), from 0.
std::int64_t npy_plane(const MeasuredSource& source, const std::vector<std::int64_t>& shape) {
  const std::int64_t planes = shape.size() == 3 ? shape[0] : 1;
  if (!source.plane && planes > 1)
    throw MissingFact("plane", source.path, "header, 'shape'", fmt::format("a cube of {} planes", planes),
                      "option 'plane', from 1 on");
  const std::int64_t plane = source.plane.value_or(1);
  if (plane < 1 || plane > planes)
    throw InputError(source.path, "option 'plane'", fmt::format("{}", plane),
                     planes == 1 ? "1, the only plane" : fmt::format("a plane from 1 to {}", planes));
  return plane - 1;
}

}  // namespace

HeightMap read_npy(const MeasuredSource& source) {
  require_sane_options(source);
  const std::string& path = source.path;
  const std::string bytes = read_map_bytes(path);
  const NpyHeader header = npy_header(path, FileBytes(path, bytes, std::endian::little));
  const NpyType type = npy_type(path, header.type);
  const FileBytes file(path, bytes, header.type.starts_with('>') ? std::endian::big : std::endian::little);
  const std::vector<std::int64_t>& shape = header.shape;
  const std::size_t axes = shape.size();
  if (axes != 2 && axes != 3)
    throw InputError(
        path, "header, 'shape'", fmt::format("an array of {} axes", axes),
        "a matrix of heights, or a cube of planes, rows and columns; save profiles as text in columns");
  const std::int64_t rows = shape[axes - 2], columns = shape[axes - 1], planes = axes == 3 ? shape[0] : 1;
  require_map_size(path, "header, 'shape'", columns, rows);
  const std::uint64_t points = std::uint64_t(rows) * std::uint64_t(columns),
                      left = bytes.size() - header.data;
  if (planes < 1 || points * type.bytes > left / std::uint64_t(planes))
    file.fail(header.data, fmt::format("{} bytes", left),
              fmt::format("{} x {} x {} values of {} bytes", planes, rows, columns, type.bytes));
  const std::int64_t plane = npy_plane(source, shape);
  if (!source.wavefront)
    throw MissingFact("of", path, "option 'of'", "nothing",
                      "wavefront (heights of a reflected wavefront) or surface, which a .npy does not state");
  const double factor = surface_per_height(*source.wavefront) *
                        given_value_factor(source, "", "heights without unit",
                                           "option 'value_unit', because a .npy has no unit");
  const double pitch = agreed_pitch(source, 0);
  HeightMap map = empty_map(rows, columns, pitch, pitch);
  map.file_unit = factor;
  for (std::int64_t row = 0; row < rows; ++row)
    for (std::int64_t column = 0; column < columns; ++column) {
      const std::int64_t index = header.fortran_order ? plane + planes * (row + rows * column)
                                                      : (plane * rows + row) * columns + column;
      const double value = factor * type.read(file, header.data + std::uint64_t(index) * type.bytes);
      // As in a text matrix, the first row is at the top unless the option states otherwise.
      if (std::isfinite(value)) map.height(source.bottom_first ? row : rows - 1 - row, column) = value;
    }
  return map;
}

}  // namespace aberfit
