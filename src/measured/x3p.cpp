// ISO 25178-72 (before: ISO 5436-2) .x3p: a zip archive with main.xml, which describes axes and size, and the
// heights in a binary file, little-endian. As in the schema of openGPS; meaning of types and the mask of
// valid points also as in Gwyddion (modules/file/opengps.c).
#include <fmt/format.h>
#include <zip.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>

#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

// A zip archive in memory.
class X3pArchive {
 public:
  X3pArchive(const std::string& path, const std::string& bytes) : path_(path), size_(bytes.size()) {
    zip_error_t error;
    zip_error_init(&error);
    zip_source_t* const bytes_of = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
    if (bytes_of != nullptr) archive_ = zip_open_from_source(bytes_of, ZIP_RDONLY, &error);
    const std::string message = one_line(zip_error_strerror(&error), 200);
    if (archive_ == nullptr && bytes_of != nullptr) zip_source_free(bytes_of);
    zip_error_fini(&error);
    if (archive_ == nullptr) throw InputError(path_, "", message, "an x3p file, a zip archive");
  }
  ~X3pArchive() { zip_discard(archive_); }
  X3pArchive(const X3pArchive&) = delete;
  X3pArchive& operator=(const X3pArchive&) = delete;

  /// The content of a file of the archive, of at most `most` bytes; checked by its CRC.
  std::string content(const std::string& name, std::uint64_t most) const {
    zip_stat_t about;
    zip_stat_init(&about);
    if (zip_stat(archive_, name.c_str(), 0, &about) != 0)
      throw InputError(path_, one_line(name, 80), "nothing", "a file of that name in the archive");
    constexpr zip_uint64_t kWanted =
        ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;
    if ((about.valid & kWanted) != kWanted)
      fail(name, "an incomplete entry", "size and method of the packed file");
    if (about.encryption_method != ZIP_EM_NONE) fail(name, "encrypted content", "content without a password");
    if (about.comp_method != ZIP_CM_STORE && about.comp_method != ZIP_CM_DEFLATE)
      fail(name, fmt::format("compression method {}", about.comp_method), "0 (stored) or 8 (deflate)");
    const std::uint64_t packed = std::min<std::uint64_t>(about.comp_size, size_);
    if (about.size > most || about.size / kMostByDeflate > packed)
      fail(name, fmt::format("{} bytes, packed in {}", about.size, packed),
           fmt::format("at most {} bytes", most));
    std::string bytes(std::size_t(about.size), '\0');
    zip_file_t* const file = zip_fopen(archive_, name.c_str(), 0);
    if (file == nullptr) fail(name, one_line(zip_strerror(archive_), 200), "content that can be unpacked");
    std::size_t got = 0;
    zip_int64_t read = 1;
    while (read > 0 && got < bytes.size()) {
      read = zip_fread(file, bytes.data() + got, bytes.size() - got);
      if (read > 0) got += std::size_t(read);
    }
    // The CRC is looked at where the content ends.
    char beyond = 0;
    const zip_int64_t after = read < 0 ? read : zip_fread(file, &beyond, 1);
    const std::string message = after < 0 ? one_line(zip_file_strerror(file), 200) : "another length";
    zip_fclose(file);
    if (after != 0 || got < bytes.size())
      fail(name, fmt::format("{} after {} bytes", message, got), fmt::format("{} bytes", about.size));
    return bytes;
  }

 private:
  [[noreturn]] void fail(const std::string& name, const std::string& found,
                         const std::string& allowed) const {
    throw InputError(path_, one_line(name, 80), found, allowed);
  }

  const std::string& path_;
  std::uint64_t size_;
  zip_t* archive_ = nullptr;
};

// main.xml, by paths such as "Record1/Axes/CX/Increment" below the root; prefixes of name spaces are no part
// of them.
class X3pMain {
 public:
  X3pMain(const std::string& path, const std::string& text) : path_(path) {
    const pugi::xml_parse_result result = document_.load_buffer(text.data(), text.size());
    if (!result)
      throw InputError(path_, fmt::format("main.xml, byte {}", result.offset), result.description(),
                       "well-formed XML");
    root_ = document_.document_element();
    if (local_name(root_) != "ISO5436_2")
      throw InputError(path_, "main.xml", fmt::format("the element {}", in_quotes(root_.name())),
                       "ISO5436_2");
  }

  /// Empty where there is no such element.
  std::string text(std::string_view place) const {
    pugi::xml_node node = root_;
    for (const std::string_view name : words(place, "/"))
      node = node.find_child([&](const pugi::xml_node& child) { return local_name(child) == name; });
    return std::string(trimmed(node.text().get()));
  }
  std::optional<double> number(std::string_view place) const {
    const std::string found = text(place);
    if (found.empty()) return std::nullopt;
    const auto value = parse_finite(found);
    if (!value) fail(place, in_quotes(found), "a number");
    return value;
  }
  void require(std::string_view place, std::string_view wanted, const std::string& meaning) const {
    const std::string found = text(place);
    if (found != wanted)
      fail(place, found.empty() ? "nothing" : in_quotes(found), fmt::format("{}, {}", wanted, meaning));
  }
  std::int64_t count(std::string_view place) const {
    const std::string found = text(place);
    const auto value = parse_number<std::int64_t>(found);
    if (!value) fail(place, found.empty() ? "nothing" : in_quotes(found), "a whole number");
    return *value;
  }
  [[noreturn]] void fail(std::string_view place, const std::string& found, const std::string& allowed) const {
    throw InputError(path_, fmt::format("main.xml, {}", place), found, allowed);
  }

 private:
  static std::string_view local_name(const pugi::xml_node& node) {
    const std::string_view name = node.name();
    return name.substr(name.find(':') + 1);  // npos + 1 is 0
  }

  const std::string& path_;
  pugi::xml_document document_;
  pugi::xml_node root_;
};

struct X3pType {
  std::uint64_t bytes = 0;
  double (*read)(const FileBytes& file, std::uint64_t place) = nullptr;
  bool integer = false;
};

template <class Number>
X3pType x3p_type() {
  return {sizeof(Number),
          [](const FileBytes& file, std::uint64_t place) { return double(file.at<Number>(place)); },
          std::numeric_limits<Number>::is_integer};
}

X3pType type_of_heights(const X3pMain& main) {
  constexpr const char* kPlace = "Record1/Axes/CZ/DataType";
  const std::string name = main.text(kPlace);
  if (name == "I") return x3p_type<std::int16_t>();
  if (name == "L") return x3p_type<std::int32_t>();
  if (name == "F") return x3p_type<float>();
  if (name == "D") return x3p_type<double>();
  main.fail(kPlace, name.empty() ? "nothing" : in_quotes(name), "I, L, F or D");
}

// Metres in one unit of the heights.
double x3p_factor(const MeasuredSource& source, const X3pMain& main, const X3pType& type) {
  constexpr const char* kPlace = "Record1/Axes/CZ/Increment";
  std::optional<double> said = main.number(kPlace);
  if (said && *said == 0) main.fail(kPlace, "0", "a number other than 0 [m]");
  if (!said && !type.integer) said = 1;
  if (!said)
    return given_value_factor(source, fmt::format("main.xml, {}", kPlace), "nothing, for integers",
                              "a number [m], or option 'value_unit'");
  return agreed_value_factor(source, *said, "CZ/Increment");
}

}  // namespace

HeightMap read_x3p(const MeasuredSource& source) {
  require_sane_options(source);
  const std::string bytes = read_map_bytes(source.path);
  const X3pArchive archive(source.path, bytes);
  constexpr std::uint64_t kMostXml = 1 << 24;
  const X3pMain main(source.path, archive.content("main.xml", kMostXml));
  main.require("Record1/FeatureType", "SUR", "a surface");
  for (const char* axis : {"CX", "CY"})
    main.require(fmt::format("Record1/Axes/{}/AxisType", axis), "I", "positions in equal steps");
  main.require("Record1/Axes/CZ/AxisType", "A", "heights");
  const std::int64_t columns = main.count("Record3/MatrixDimension/SizeX"),
                     rows = main.count("Record3/MatrixDimension/SizeY");
  require_map_size(source.path, "main.xml, Record3/MatrixDimension", columns, rows);
  main.require("Record3/MatrixDimension/SizeZ", "1", "one layer");
  const X3pType type = type_of_heights(main);
  agreed_wavefront(source.path, source.wavefront, false);
  const double factor = x3p_factor(source, main, type);
  const double offset = main.number("Record1/Axes/CZ/Offset").value_or(0);
  const double step_x = main.number("Record1/Axes/CX/Increment").value_or(0),
               step_y = main.number("Record1/Axes/CY/Increment").value_or(0);

  const auto linked = [&](const char* place, std::uint64_t length) {
    const std::string name = main.text(place);
    if (name.empty()) return std::string();
    std::string content = archive.content(name, length);
    if (content.size() < length)
      throw InputError(source.path, one_line(name, 80), fmt::format("{} bytes", content.size()),
                       fmt::format("{} bytes, as {} x {} points have", length, columns, rows));
    return content;
  };
  const std::uint64_t points = std::uint64_t(columns) * std::uint64_t(rows);
  constexpr const char* kLink = "Record3/DataLink/PointDataLink";
  const std::string heights = linked(kLink, points * type.bytes);
  if (heights.empty())
    main.fail(kLink, "nothing", "the name of the binary file of the heights in the archive");
  // One bit a point, the lowest bit first.
  const std::string valid = linked("Record3/DataLink/ValidPointsLink", (points + 7) / 8);
  const FileBytes values(source.path, heights, std::endian::little);
  HeightMap map = empty_map(rows, columns, agreed_pitch(source, std::abs(step_x)),
                            agreed_pitch(source, std::abs(step_y)));
  map.label = one_line(main.text("Record2/Comment"), 80);
  for (std::uint64_t point = 0; point < points; ++point) {
    const double value = type.read(values, point * type.bytes);
    const bool masked =
        !valid.empty() && (static_cast<unsigned char>(valid[point / 8]) >> (point % 8) & 1) == 0;
    if (masked || !std::isfinite(value)) continue;
    // Positions are those that the axes give: both ascend with the index where their steps are positive.
    const Eigen::Index row = Eigen::Index(point) / columns, column = Eigen::Index(point) % columns;
    map.height(step_y < 0 ? rows - 1 - row : row, step_x < 0 ? columns - 1 - column : column) =
        offset + factor * value;
  }
  return map;
}

}  // namespace aberfit
