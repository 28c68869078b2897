// Wyko / Veeco / Bruker Vision .opd, binary and little-endian. The layout is not published. This reader
// follows what Gwyddion (modules/file/opdfile.c) and SurfaceTopography (IO/OPD.py) agree on.
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr std::uint64_t kRecord = 24;  // bytes of a directory record: name 16, type 2, length 4, flags 2
enum OpdType : unsigned {
  kOpdArray = 3,
  kOpdText = 5,
  kOpdShort = 6,
  kOpdFloat = 7,
  kOpdDouble = 8,
  kOpdLong = 12
};

struct OpdBlock {
  std::string name;
  unsigned type = 0;
  std::uint64_t record = 0;  // position in the directory
  std::uint64_t first = 0, length = 0;
};

std::string opd_name(std::string_view bytes) {
  return std::string(trimmed(bytes.substr(0, bytes.find('\0'))));
}

// Returns the blocks with content. They follow the directory without gaps and in its order.
std::vector<OpdBlock> opd_blocks(const FileBytes& file) {
  const std::string allowed = "a Wyko .opd, which begins with the bytes 1 and 0 and the word Directory";
  if (file.size() < 2 + kRecord) file.fail(0, fmt::format("a file of {} bytes", file.size()), allowed);
  if (file.at<std::uint16_t>(0) != 1 || opd_name(file.text(2, 16)) != "Directory")
    file.fail(0, in_quotes(file.text(0, 18)), allowed);
  const std::uint64_t directory = file.at<std::uint32_t>(20);
  if (directory < kRecord || directory % kRecord != 0 || !file.holds(2, directory))
    file.fail(20, fmt::format("a directory of {} bytes in a file of {}", directory, file.size()),
              fmt::format("records of {} bytes, at least one", kRecord));
  std::vector<OpdBlock> blocks;
  std::uint64_t first = 2 + directory;
  for (std::uint64_t record = 2 + kRecord; record < 2 + directory; record += kRecord) {
    const std::uint64_t length = file.at<std::uint32_t>(record + 18);
    if (!file.holds(first, length))
      file.fail(record,
                fmt::format("a block of {} bytes that begins at byte {}, in a file of {} bytes", length,
                            first, file.size()),
                "blocks inside the file");
    if (length > 0)
      blocks.push_back(
          {opd_name(file.text(record, 16)), file.at<std::uint16_t>(record + 16), record, first, length});
    first += length;
  }
  return blocks;
}

const OpdBlock* opd_block(const std::vector<OpdBlock>& blocks, std::string_view name) {
  for (const OpdBlock& block : blocks)
    if (block.name == name) return &block;
  return nullptr;
}

std::optional<double> opd_number(const FileBytes& file, const std::vector<OpdBlock>& blocks,
                                 std::string_view name) {
  const OpdBlock* const block = opd_block(blocks, name);
  if (block == nullptr) return std::nullopt;
  if (block->type == kOpdShort && block->length == 2) return file.at<std::int16_t>(block->first);
  if (block->type == kOpdLong && block->length == 4) return file.at<std::int32_t>(block->first);
  if (block->type == kOpdFloat && block->length == 4) return file.at<float>(block->first);
  if (block->type == kOpdDouble && block->length == 8) return file.at<double>(block->first);
  file.fail(block->record, fmt::format("{} of type {} and {} bytes", name, block->type, block->length),
            "a number: type 6 of 2 bytes, 7 or 12 of 4, 8 of 8");
}

// Returns the array of heights: the first one, unless the file declares another one as its primary data.
const OpdBlock& heights_block(const FileBytes& file, const std::vector<OpdBlock>& blocks) {
  constexpr std::string_view kHeights[] = {"Raw", "RAW DATA", "RAW_DATA", "OPD", "SAMPLE_DATA"};
  const auto is_heights = [&](const OpdBlock& block) {
    return std::find(std::begin(kHeights), std::end(kHeights), block.name) != std::end(kHeights);
  };
  const OpdBlock* found = nullptr;
  for (const OpdBlock& block : blocks)
    if (is_heights(block) && found == nullptr) found = &block;
  // The block holds two bytes of type, one of length, then the name.
  if (const OpdBlock* const main = opd_block(blocks, "PrimaryData2D"); main != nullptr && main->length > 3)
    if (const OpdBlock* const named =
            opd_block(blocks, opd_name(file.text(main->first + 3, main->length - 3)));
        named != nullptr && is_heights(*named))
      found = named;
  if (found == nullptr)
    file.fail(2, "no block of heights", "a block Raw, RAW DATA, RAW_DATA, OPD or SAMPLE_DATA");
  if (found->type != kOpdArray || found->length < 6)
    file.fail(found->record,
              fmt::format("{} of type {} and {} bytes", in_quotes(found->name), found->type, found->length),
              "type 3, an array");
  return *found;
}

// Returns the height [m] of one unit of the array.
double opd_factor(const MeasuredSource& source, const FileBytes& file, const std::vector<OpdBlock>& blocks) {
  // Limits in nanometres. A value outside is a wavelength in another unit, or damage.
  constexpr double kShortest = 1, kLongest = 1e6;
  const std::optional<double> said = opd_number(file, blocks, "Wavelength");
  const bool sane = said && *said >= kShortest && *said <= kLongest;
  if (!said && source.value_factor) return *source.value_factor;
  constexpr const char* kAllowed = "1 to 1e6 nm, or option 'wavelength'";
  if (!said && !source.wavelength)
    throw MissingFact("wavelength", source.path, "Wavelength", "nothing", kAllowed);
  if (!sane && !source.wavelength)
    throw InputError(source.path, "Wavelength", fmt::format("{} nm", *said), kAllowed);
  const double wavelength =
      *agreed_length(source.path, "wavelength", source.wavelength,
                     sane ? std::optional(*said * 1e-9) : std::nullopt, kSameWavelength);
  const double parts = opd_number(file, blocks, "Mult").value_or(1);
  if (!(parts > 0 && std::isfinite(parts)))
    throw InputError(source.path, "Mult", fmt::format("{}", parts),
                     "a positive number, the counts per wavelength");
  return agreed_value_factor(source, wavelength / parts, "Wavelength / Mult");
}

}  // namespace

HeightMap read_opd(const MeasuredSource& source) {
  require_sane_options(source);
  const std::string bytes = read_map_bytes(source.path);
  const FileBytes file(source.path, bytes, std::endian::little);
  const std::vector<OpdBlock> blocks = opd_blocks(file);
  const OpdBlock& heights = heights_block(file, blocks);
  const std::int64_t columns = file.at<std::uint16_t>(heights.first),
                     rows = file.at<std::uint16_t>(heights.first + 2);
  const unsigned width = file.at<std::uint16_t>(heights.first + 4);
  require_map_size(source.path, fmt::format("byte {}", heights.first), columns, rows);
  if (width != 2 && width != 4)
    file.fail(heights.first + 4, fmt::format("values of {} bytes", width),
              "2 (integers) or 4 (floating point)");
  if (heights.length - 6 < std::uint64_t(columns * rows) * width)
    file.fail(heights.record, fmt::format("a block of {} bytes", heights.length),
              fmt::format("6 + {} x {} x {} bytes", columns, rows, width));
  agreed_wavefront(source.path, source.wavefront, false);
  const double factor = opd_factor(source, file, blocks);
  // Pitch of a pixel along y over that along x.
  const double aspect = opd_number(file, blocks, "Aspect").value_or(1);
  if (!(aspect > 0 && std::isfinite(aspect)))
    throw InputError(source.path, "Aspect", fmt::format("{}", aspect), "a positive number");
  const double pitch_x =
      agreed_pitch(source, opd_number(file, blocks, "Pixel_size").value_or(0) * 1e-3);  // the file has mm

  HeightMap map = empty_map(rows, columns, pitch_x, pitch_x * aspect);
  if (const OpdBlock* const title = opd_block(blocks, "Title"); title != nullptr && title->type == kOpdText)
    map.label = one_line(opd_name(file.text(title->first, title->length)), 80);
  // Columns are stored in sequence, each from its lowest point upwards. Values from these on mean no data.
  constexpr double kNoInteger = 32766, kNoFloat = 1e38;
  std::uint64_t place = heights.first + 6;
  for (Eigen::Index column = 0; column < columns; ++column)
    for (Eigen::Index row = 0; row < rows; ++row, place += width) {
      const double value = width == 2 ? double(file.at<std::int16_t>(place)) : double(file.at<float>(place));
      if (std::isfinite(value) && value < (width == 2 ? kNoInteger : kNoFloat))
        map.height(row, column) = factor * value;
    }
  return map;
}

}  // namespace aberfit
