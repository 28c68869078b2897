// Surface data files .sdf: ISO 25178-71 (ISO-1.0, ISO-2.0) and its predecessor BCR-1.0 (EUR 15178 EN), text
// and binary, little-endian. Header and types follow the tables of NPL's softgauges and of NIST's surface
// metrology pages. Counts of ISO-2.0, order of rows and no-data marks follow the project sdfio.
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <string_view>

#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

struct SdfType {
  std::uint64_t bytes;
  double lowest, highest;
  double (*read)(const FileBytes& file, std::uint64_t place);
};

template <class Number>
constexpr SdfType sdf_type() {
  using Limits = std::numeric_limits<Number>;
  return {sizeof(Number), double(Limits::lowest()), double(Limits::max()),
          [](const FileBytes& file, std::uint64_t place) { return double(file.at<Number>(place)); }};
}

// Types in the order of DataType.
constexpr SdfType kSdfTypes[] = {
    sdf_type<std::uint8_t>(), sdf_type<std::uint16_t>(), sdf_type<std::uint32_t>(), sdf_type<float>(),
    sdf_type<std::int8_t>(),  sdf_type<std::int16_t>(),  sdf_type<std::int32_t>(),  sdf_type<double>()};

constexpr std::size_t kMagicBytes = 8;

struct SdfHeader {
  bool bcr = false;                                   // BCR rather than ISO
  bool wide = false;                                  // binary: counts have four bytes
  std::map<std::string, double, std::less<>> number;  // by the names of the text form
  std::string manufacturer;
};

SdfHeader header_of_version(const std::string& path, std::string_view magic) {
  const std::string_view version = magic.substr(1);
  if (version != "ISO-1.0" && version != "ISO-2.0" && version != "BCR-1.0" && version != "BCR-0.0")
    throw InputError(path, "version", in_quotes(magic),
                     "ISO-1.0, ISO-2.0 or BCR-1.0, with an a (text) or a b (binary) before it");
  SdfHeader header;
  header.bcr = version.starts_with("BCR");
  header.wide = version == "ISO-2.0";
  return header;
}

// A checked header: it makes an empty map and puts values into it.
class SdfGrid {
 public:
  SdfGrid(const MeasuredSource& source, const SdfHeader& header) : path_(source.path), bcr_(header.bcr) {
    for (const char* key : {"Compression", "CheckType"})
      if (number(header, key) != 0)
        throw InputError(path_, key, fmt::format("{}", number(header, key)), "0, none");
    const double type = number(header, "DataType");
    // Unsigned types leave no number for ISO's no-data mark.
    const double first = bcr_ ? 0 : 3;
    if (!(type >= first && type <= 7) || type != std::floor(type))
      throw InputError(path_, "DataType", fmt::format("{}", type),
                       fmt::format("an integer from {} to 7", first));
    type_ = &kSdfTypes[std::size_t(type)];
    const double columns = number(header, "NumPoints"), rows = number(header, "NumProfiles");
    for (const double count : {columns, rows})
      if (!(count >= 1 && count <= double(kMostMapPoints)) || count != std::floor(count))
        throw InputError(path_, "NumPoints, NumProfiles", fmt::format("{} x {} points", columns, rows),
                         fmt::format("1 to {} points", kMostMapPoints));
    require_map_size(path_, "NumPoints, NumProfiles", std::int64_t(columns), std::int64_t(rows));
    if (rows == 1) throw InputError(path_, "NumProfiles", "1, a profile", "2 or more, a map");
    columns_ = Eigen::Index(columns);
    rows_ = Eigen::Index(rows);
    const double z_scale = number(header, "Zscale");
    if (!(z_scale > 0 && std::isfinite(z_scale)))
      throw InputError(path_, "Zscale", fmt::format("{}", z_scale), "a positive number [m]");
    factor_ = agreed_value_factor(source, z_scale, "Zscale");
    agreed_wavefront(path_, source.wavefront, false);
    pitch_x_ = agreed_pitch(source, number(header, "Xscale"));
    pitch_y_ = agreed_pitch(source, number(header, "Yscale"));
  }

  std::int64_t points() const { return std::int64_t(columns_) * rows_; }
  std::string size_text() const { return fmt::format("{} x {} points", columns_, rows_); }
  const SdfType& type() const { return *type_; }
  HeightMap empty() const { return empty_map(rows_, columns_, pitch_x_, pitch_y_); }
  /// ISO orders profiles from y = 0 upwards. BCR defines no order; viewers show the first profile at the top.
  void put(std::int64_t point, double value, HeightMap* map) const {
    const bool measured = std::isfinite(value) && value != (bcr_ ? type_->highest : type_->lowest);
    const Eigen::Index row = Eigen::Index(point) / columns_;
    if (measured) map->height(bcr_ ? rows_ - 1 - row : row, Eigen::Index(point) % columns_) = factor_ * value;
  }

 private:
  double number(const SdfHeader& header, std::string_view key) const {
    const auto found = header.number.find(key);
    if (found == header.number.end())
      throw InputError(path_, std::string(key), "nothing", fmt::format("the line {} = ...", key));
    return found->second;
  }

  const std::string& path_;
  bool bcr_;
  const SdfType* type_ = nullptr;
  Eigen::Index rows_ = 0, columns_ = 0;
  double factor_ = 0, pitch_x_ = 0, pitch_y_ = 0;
};

constexpr std::string_view kSdfNumbers[] = {"NumPoints",   "NumProfiles", "Xscale",   "Yscale",   "Zscale",
                                            "Zresolution", "Compression", "DataType", "CheckType"};

// Reads the lines up to that with the asterisk, which is then the last line of `lines`.
SdfHeader text_header(const std::string& path, TextLines* lines) {
  std::string_view line;
  SdfHeader header = header_of_version(path, lines->next(&line) ? trimmed(line) : std::string_view());
  while (true) {
    if (!lines->next(&line)) lines->fail("the end of the file", "a line with an asterisk, then the heights");
    line = trimmed(line);
    if (line == "*") return header;
    const std::size_t equals = line.find('=');
    if (line.starts_with(';') || equals == line.npos) continue;
    const std::string_view key = trimmed(line.substr(0, equals)), text = trimmed(line.substr(equals + 1));
    if (key == "ManufacID") header.manufacturer = one_line(text, 80);
    for (const std::string_view name : kSdfNumbers) {
      if (lower_case(key) != lower_case(name)) continue;
      const auto value = parse_finite(text);
      if (!value) lines->fail(fmt::format("{} = {}", name, in_quotes(text)), "a number");
      header.number[std::string(name)] = *value;
    }
  }
}

HeightMap read_sdf_text(const MeasuredSource& source) {
  TextLines lines(source.path);
  const SdfHeader header = text_header(source.path, &lines);
  const SdfGrid grid(source, header);
  // Every value needs a digit and a blank. Checking this first avoids allocating more than the file can hold.
  if (grid.points() > std::int64_t(lines.bytes_left() / 2 + 1))
    lines.fail(fmt::format("{} before {} bytes of heights", grid.size_text(), lines.bytes_left()),
               "a file that holds every point");
  HeightMap map = grid.empty();
  map.label = header.manufacturer;
  std::int64_t point = 0;
  bool more = true;
  for (std::string_view line; more && lines.next(&line);)
    for (const std::string_view word : words(line)) {
      more = word != "*";  // remarks follow
      if (!more) break;
      const std::string mark = upper_case(word);
      const bool hole = mark == "BAD" || mark == "NAN";
      const auto value = hole ? std::numeric_limits<double>::quiet_NaN() : parse_finite(word);
      if (!value) lines.fail(in_quotes(word), "a number, BAD or the asterisk behind the heights");
      if (point == grid.points()) lines.fail("a number after the last point", grid.size_text());
      grid.put(point++, *value, &map);
    }
  if (point < grid.points())
    lines.fail(fmt::format("the end of the heights after {} numbers", point), grid.size_text());
  return map;
}

SdfHeader binary_header(const std::string& path, const FileBytes& file, std::uint64_t* place) {
  SdfHeader header = header_of_version(path, file.text(0, kMagicBytes));
  header.manufacturer = one_line(file.text(kMagicBytes, 10), 10);
  *place = kMagicBytes + 10 + 2 * 12;  // two dates
  const auto take = [&]<class Number>(const char* key, Number) {
    header.number[key] = double(file.at<Number>(*place));
    *place += sizeof(Number);
  };
  for (const char* key : {"NumPoints", "NumProfiles"}) {
    if (header.wide)
      take(key, std::uint32_t());
    else
      take(key, std::uint16_t());
  }
  for (const char* key : {"Xscale", "Yscale", "Zscale", "Zresolution"}) take(key, double());
  for (const char* key : {"Compression", "DataType", "CheckType"}) take(key, std::uint8_t());
  return header;
}

HeightMap read_sdf_binary(const MeasuredSource& source, std::string_view bytes) {
  const FileBytes file(source.path, bytes, std::endian::little);
  std::uint64_t first = 0;
  const SdfHeader header = binary_header(source.path, file, &first);
  const SdfGrid grid(source, header);
  const std::uint64_t width = grid.type().bytes, needed = width * std::uint64_t(grid.points());
  if (!file.holds(first, needed))
    file.fail(file.size(),
              fmt::format("the end of the file, {} bytes too early", first + needed - file.size()),
              fmt::format("{} of {} bytes each, which begin at byte {}", grid.size_text(), width, first));
  HeightMap map = grid.empty();
  map.label = header.manufacturer;
  for (std::int64_t point = 0; point < grid.points(); ++point)
    grid.put(point, grid.type().read(file, first + width * std::uint64_t(point)), &map);
  return map;
}

}  // namespace

HeightMap read_sdf(const MeasuredSource& source) {
  require_sane_options(source);
  const std::string bytes = read_map_bytes(source.path);
  if (bytes.starts_with('a')) return read_sdf_text(source);
  return read_sdf_binary(source, bytes);
}

}  // namespace aberfit
