#include "npz.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdint>
#include <stdexcept>

namespace aberfit::internal {
namespace {

template <typename Integer>
void add_little_endian(Integer value, std::string* bytes) {
  for (std::size_t k = 0; k < sizeof value; ++k) *bytes += char((value >> (8 * k)) & 0xff);
}

// Adds the common part of the header of a file and its entry in the directory, from the version needed to
// read it to the length of its name.
void add_zip_entry(const std::string& name, const std::string& content, std::string* bytes) {
  constexpr std::uint16_t kVersion = 20, kStored = 0, kFirstOfJanuary1980 = 0x21;
  const auto size = std::uint32_t(content.size());
  for (const std::uint16_t number :
       {kVersion, std::uint16_t(0), kStored, std::uint16_t(0), kFirstOfJanuary1980})
    add_little_endian(number, bytes);
  for (const std::uint32_t number : {crc32_of(content), size, size}) add_little_endian(number, bytes);
  add_little_endian(std::uint16_t(name.size()), bytes);
  add_little_endian(std::uint16_t(0), bytes);  // no extra field
}

}  // namespace

std::uint32_t crc32_of(std::string_view bytes) {
  static const std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> made{};
    for (std::uint32_t k = 0; k < 256; ++k) {
      std::uint32_t value = k;
      for (int bit = 0; bit < 8; ++bit) value = value & 1 ? 0xEDB88320u ^ (value >> 1) : value >> 1;
      made[k] = value;
    }
    return made;
  }();
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const char byte : bytes) crc = table[(crc ^ std::uint8_t(byte)) & 0xff] ^ (crc >> 8);
  return ~crc;
}

std::string npy_bytes(const NpyArray& array) {
  constexpr std::size_t kAlignment = 64, kBeforeText = 10;
  std::string shape;
  for (const Eigen::Index size : array.shape) shape += fmt::format("{}, ", size);
  std::string text = fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}), }}", shape);
  const std::size_t used = (kBeforeText + text.size() + 1) % kAlignment;
  text += std::string((kAlignment - used) % kAlignment, ' ') + '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  add_little_endian(std::uint16_t(text.size()), &bytes);
  bytes += text;
  bytes.reserve(bytes.size() + 8 * array.values.size());
  for (const double value : array.values) add_little_endian(std::bit_cast<std::uint64_t>(value), &bytes);
  return bytes;
}

std::string stored_zip(const std::vector<std::pair<std::string, std::string>>& files) {
  std::string bytes, directory;
  for (const auto& [name, content] : files) {
    const auto at = std::uint32_t(bytes.size());
    add_little_endian(std::uint32_t(0x04034b50), &bytes);
    add_zip_entry(name, content, &bytes);
    bytes += name;
    bytes += content;
    if (bytes.size() > 0xF0000000u) throw std::runtime_error("a zip archive of more than 4 GiB");
    add_little_endian(std::uint32_t(0x02014b50), &directory);
    add_little_endian(std::uint16_t(20), &directory);  // version of the writer
    add_zip_entry(name, content, &directory);
    // There is no comment, the first disk, and no attributes.
    for (int k = 0; k < 3; ++k) add_little_endian(std::uint16_t(0), &directory);
    add_little_endian(std::uint32_t(0), &directory);
    add_little_endian(at, &directory);
    directory += name;
  }
  const auto begin = std::uint32_t(bytes.size()), size = std::uint32_t(directory.size());
  const auto count = std::uint16_t(files.size());
  bytes += directory;
  add_little_endian(std::uint32_t(0x06054b50), &bytes);
  for (const std::uint16_t number : {std::uint16_t(0), std::uint16_t(0), count, count})
    add_little_endian(number, &bytes);
  add_little_endian(size, &bytes);
  add_little_endian(begin, &bytes);
  add_little_endian(std::uint16_t(0), &bytes);
  return bytes;
}

}  // namespace aberfit::internal
