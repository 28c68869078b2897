#include "fits_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "map_reading.h"

namespace aberfit::internal {
namespace {

constexpr std::uint64_t kBlock = 2880, kCard = 80;

class FitsHeader {
 public:
  FitsHeader(const std::string& path, std::string_view bytes, std::uint64_t start, int hdu)
      : path_(path), hdu_(hdu) {
    for (std::uint64_t at = start;; at += kCard) {
      if (at + kCard > bytes.size())
        throw InputError(path, fmt::format("hdu {}", hdu), "the end of the file before END",
                         "a header that ends with END");
      const std::string_view card = bytes.substr(at, kCard);
      for (const char c : card)
        if (c < 0x20 || c == 0x7f)
          throw InputError(path, fmt::format("hdu {}, byte {}", hdu, at), in_quotes(card),
                           "cards of 80 printable ASCII characters");
      // END must be at the beginning of the card (standard 4.1.2.1), where CFITSIO expects it. A reader that
      // accepted another END would find other data.
      if (card.starts_with("END") && trimmed(card) == "END") {
        data_ = (at + kCard + kBlock - 1) / kBlock * kBlock;
        return;
      }
      cards_.push_back(card);
    }
  }

  /// Returns the value of a key without its comment and without the quotes of a string.
  std::optional<std::string_view> value(std::string_view key) const {
    for (const std::string_view card : cards_) {
      if (!card.starts_with(key) || trimmed(card.substr(0, 8)) != key || card.substr(8, 1) != "=") continue;
      const std::string_view text = trimmed(card.substr(9));
      if (text.starts_with('\'')) return trimmed(text.substr(1, text.find('\'', 1) - 1));
      return trimmed(text.substr(0, text.find('/')));
    }
    return std::nullopt;
  }
  std::int64_t integer(const std::string& key, std::int64_t least, std::int64_t most,
                       std::optional<std::int64_t> otherwise = {}) const {
    const auto text = value(key);
    if (!text && otherwise) return *otherwise;
    const auto found = text ? parse_number<std::int64_t>(*text) : std::nullopt;
    if (!found || *found < least || *found > most)
      fail(key, text ? in_quotes(*text) : "no value", fmt::format("an integer from {} to {}", least, most));
    return *found;
  }
  bool is_true(std::string_view key) const { return value(key) == "T"; }
  std::uint64_t data() const { return data_; }
  [[noreturn]] void fail(const std::string& key, const std::string& found, const std::string& allowed) const {
    throw InputError(path_, fmt::format("hdu {}, {}", hdu_, key), found, allowed);
  }

 private:
  const std::string& path_;
  int hdu_;
  std::vector<std::string_view> cards_;
  std::uint64_t data_ = 0;  // where the data begins
};

struct Layout {
  std::vector<std::int64_t> axes;
  std::uint64_t data_bytes = 0;
};

// |BITPIX|/8 GCOUNT (PCOUNT + product of the axes). Throws InputError if it exceeds the rest of the file.
Layout layout(const FitsHeader& header, bool primary, std::uint64_t file_bytes) {
  Layout found;
  const std::int64_t bits = header.integer("BITPIX", -64, 64);
  static const std::vector<std::int64_t> kBits = {8, 16, 32, 64, -32, -64};
  if (std::find(kBits.begin(), kBits.end(), bits) == kBits.end())
    header.fail("BITPIX", std::to_string(bits), "8, 16, 32, 64, -32 or -64");
  const std::int64_t dimensions = header.integer("NAXIS", 0, 999);
  const std::int64_t most = std::int64_t(file_bytes);
  constexpr std::int64_t kAny = std::numeric_limits<std::int64_t>::max();
  for (std::int64_t i = 1; i <= dimensions; ++i)
    found.axes.push_back(header.integer(fmt::format("NAXIS{}", i), 0, kAny));
  const bool groups = primary && header.is_true("GROUPS") && !found.axes.empty() && found.axes[0] == 0;
  const std::int64_t parameters = primary && !groups ? 0 : header.integer("PCOUNT", 0, kAny, 0);
  const std::int64_t group_count = primary && !groups ? 1 : header.integer("GCOUNT", 0, kAny, 1);
  // Bytes of the file after the header; the last block may be incomplete.
  const std::int64_t left = std::max<std::int64_t>(0, most - std::int64_t(header.data()));
  const auto too_large = [&](const std::string& key) {
    std::string sizes;
    for (const std::int64_t axis : found.axes) sizes += (sizes.empty() ? "" : " x ") + std::to_string(axis);
    header.fail(key, fmt::format("data of {} values of {} bits", sizes, std::abs(bits)),
                fmt::format("at most the {} bytes that follow the header", left));
  };
  // A zero anywhere means no data, whatever the other axes are.
  const auto first = found.axes.begin() + (groups ? 1 : 0);
  std::int64_t count = dimensions == 0 ? 0 : 1;
  if (std::find(first, found.axes.end(), 0) != found.axes.end()) count = 0;
  for (auto axis = first; axis != found.axes.end() && count > 0; ++axis) {
    if (*axis > left / count) too_large(fmt::format("NAXIS{}", axis - found.axes.begin() + 1));
    count *= *axis;
  }
  const std::int64_t width = std::abs(bits) / 8;
  if (parameters > left) too_large("PCOUNT");
  count += parameters;
  if (group_count > 0 && count > left / width / group_count) too_large("BITPIX, NAXISn, PCOUNT, GCOUNT");
  found.data_bytes = std::uint64_t(count * width * group_count);
  return found;
}

FitsImage image_of(const FitsHeader& header, int hdu, const Layout& found) {
  if (found.axes[0] > kMostMapPoints / found.axes[1])
    header.fail("NAXIS1", fmt::format("an image of {} x {} pixels", found.axes[0], found.axes[1]),
                fmt::format("at most {} pixels", kMostMapPoints));
  constexpr std::size_t kLongest = 68;  // characters of a text in a card
  FitsImage image;
  image.hdu = hdu;
  image.name = one_line(header.value("EXTNAME").value_or(""), kLongest);
  for (const char* key : {"BUNIT", "Z_UNIT"})
    if (image.unit.empty()) image.unit = one_line(header.value(key).value_or(""), kLongest);
  image.columns = found.axes[0], image.rows = found.axes[1];
  for (std::size_t axis = 2; axis < found.axes.size(); ++axis) image.planes *= found.axes[axis];
  image.end = header.data() + found.data_bytes;
  return image;
}

}  // namespace

std::vector<FitsImage> find_fits_images(const std::string& path, std::string_view bytes) {
  if (!bytes.starts_with("SIMPLE  ="))
    throw InputError(path, "byte 0", in_quotes(bytes.substr(0, 9)), "a FITS file, which begins with SIMPLE");
  std::string others;
  std::vector<FitsImage> images;
  std::uint64_t start = 0;
  for (int hdu = 0; start + kCard <= bytes.size(); ++hdu) {
    const bool primary = hdu == 0;
    // Anything may follow the last unit (standard 3.5).
    if (!primary && !bytes.substr(start).starts_with("XTENSION=")) break;
    const FitsHeader header(path, bytes, start, hdu);
    if (primary && !header.is_true("SIMPLE"))
      header.fail("SIMPLE", "a file that does not conform to the standard", "SIMPLE = T");
    const Layout found = layout(header, primary, bytes.size());
    const std::string kind(primary ? "IMAGE" : header.value("XTENSION").value_or(""));
    if (kind == "IMAGE" && found.axes.size() >= 2 &&
        std::find(found.axes.begin(), found.axes.end(), 0) == found.axes.end())
      images.push_back(image_of(header, hdu, found));
    if (header.is_true("ZIMAGE"))
      others += " a tile-compressed image,";
    else if (kind != "IMAGE")
      others += " a table,";
    else if (found.axes.size() == 1 && found.axes[0] > 0)
      others += " a one-dimensional array,";
    start = header.data() + (found.data_bytes + kBlock - 1) / kBlock * kBlock;
    if (others.size() > 100) others = " many tables,";
  }
  if (!images.empty()) return images;
  throw InputError(
      path, "",
      others.empty() ? "a FITS file without image data" : "only" + others.substr(0, others.size() - 1),
      "a two-dimensional image (unpack a compressed one with funpack)");
}

const FitsImage* mask_of(const FitsImage& image, const std::vector<FitsImage>& images) {
  for (const FitsImage& other : images)
    if (other.hdu != image.hdu && other.is_mask() && other.columns == image.columns &&
        other.rows == image.rows)
      return &other;
  return nullptr;
}

std::string fits_image_list(const std::vector<FitsImage>& images) {
  constexpr std::size_t kMostListed = 8;
  std::string list;
  for (std::size_t i = 0; i < std::min(images.size(), kMostListed); ++i) {
    const FitsImage& image = images[i];
    list += fmt::format("{}{}{} ({} x {}{}, {})", i > 0 ? ", " : "", image.hdu,
                        image.name.empty() ? "" : " " + in_quotes(image.name), image.columns, image.rows,
                        image.planes > 1 ? fmt::format(" x {}", image.planes) : "",
                        image.unit.empty() ? "no unit" : image.unit);
  }
  return list + (images.size() > kMostListed ? fmt::format(" and {} more", images.size() - kMostListed) : "");
}

}  // namespace aberfit::internal
