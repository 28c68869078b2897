// ISO 25178-72 (before: ISO 5436-2) .x3p: a zip archive with main.xml, which describes axes and size, and a
// binary little-endian file of heights. The layout follows the schema of openGPS; the meaning of types and
// the mask of valid points also follow Gwyddion (modules/file/opengps.c).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "map_reading.h"
#include "zip_archive.h"

namespace aberfit {
using namespace internal;

namespace {

// Access to main.xml by paths such as "Record1/Axes/CX/Increment" below the root, without name spaces.
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

  /// Returns the text of an element; empty if it does not exist.
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

// Returns metres per unit of the heights.
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

// Returns the folder of main.xml with a slash: the top level, or the only folder with a main.xml.
std::string x3p_folder(const std::string& path, const std::vector<std::string>& names) {
  constexpr std::string_view kMain = "main.xml";
  std::vector<std::string> folders;
  for (const std::string& name : names) {
    if (name == kMain) return "";
    if (name.ends_with("/" + std::string(kMain)))
      folders.push_back(name.substr(0, name.size() - kMain.size()));
  }
  if (folders.empty()) refuse_other_zip(path, names);
  if (folders.size() > 1)
    throw InputError(path, "",
                     fmt::format("several surfaces, {}main.xml and {}main.xml", one_line(folders[0], 80),
                                 one_line(folders[1], 80)),
                     "an archive of one surface");
  return folders.front();
}

}  // namespace

HeightMap read_x3p(const MeasuredSource& source) {
  require_sane_options(source);
  const std::string bytes = read_map_bytes(source.path);
  const ZipArchive archive(source.path, bytes, "an x3p file, a zip archive");
  const std::string folder = x3p_folder(source.path, archive.names());
  constexpr std::uint64_t kMostXml = 1 << 24;
  const X3pMain main(source.path, archive.content(folder + "main.xml", kMostXml));
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
    std::string content = archive.content(folder + name, length);
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
  // The mask has one bit per point, the lowest bit first.
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
    // The axes give the positions: they ascend with the index where the step is positive.
    const Eigen::Index row = Eigen::Index(point) / columns, column = Eigen::Index(point) % columns;
    map.height(step_y < 0 ? rows - 1 - row : row, step_x < 0 ? columns - 1 - column : column) =
        offset + factor * value;
  }
  return map;
}

}  // namespace aberfit
