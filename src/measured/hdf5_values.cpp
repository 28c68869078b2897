#include "hdf5_values.h"

#include <fmt/format.h>

#include <vector>

namespace aberfit::internal {
namespace {

struct Hdf5Block {
  std::uint64_t place, length;
};

constexpr unsigned kHdf5Attribute = 0x0c, kHdf5Continuation = 0x10;

// Version 1 pads name, type and space to multiples of 8; version 3 has a byte for the characters of the name.
void take_attribute(const FileBytes& file, std::uint64_t place, std::uint64_t length,
                    std::map<std::string, std::string_view>* values) {
  const FileBytes body = file.part(place, length);
  const unsigned version = body.at<std::uint8_t>(0);
  if (version < 1 || version > 3)
    file.fail(place, fmt::format("an attribute of version {}", version), "1 to 3");
  const auto padded = [&](std::uint64_t bytes) { return version == 1 ? (bytes + 7) / 8 * 8 : bytes; };
  const std::uint64_t name_bytes = body.at<std::uint16_t>(2);
  const std::uint64_t name = version == 3 ? 9 : 8;
  const std::uint64_t value =
      name + padded(name_bytes) + padded(body.at<std::uint16_t>(4)) + padded(body.at<std::uint16_t>(6));
  const std::string_view text = body.text(name, name_bytes);
  if (!body.holds(value, 0)) file.fail(place, "an attribute beyond its message", "a value inside it");
  values->emplace(std::string(text.substr(0, text.find('\0'))), body.text(value, body.size() - value));
}

// Where the first messages of an object header are.
Hdf5Block first_block(const FileBytes& file, std::uint64_t header, bool second, unsigned flags) {
  if (!second) return {header + 16, file.at<std::uint32_t>(header + 8)};
  std::uint64_t place = header + 6 + (flags & 0x20 ? 16 : 0) + (flags & 0x10 ? 4 : 0);
  std::uint64_t length = 0;
  const unsigned width = 1u << (flags & 3);
  for (unsigned i = 0; i < width; ++i) length |= std::uint64_t(file.at<std::uint8_t>(place + i)) << (8 * i);
  return {place + width, length};
}

}  // namespace

std::map<std::string, std::string_view> hdf5_attribute_values(const FileBytes& file, std::uint64_t header) {
  const bool second = file.holds(header, 4) && file.text(header, 4) == "OHDR";
  const unsigned version = file.at<std::uint8_t>(second ? header + 4 : header);
  if (version != (second ? 2 : 1))
    file.fail(header, fmt::format("an object header of version {}", version), "1 or 2");
  const unsigned flags = second ? file.at<std::uint8_t>(header + 5) : 0;
  std::map<std::string, std::string_view> values;
  std::vector<Hdf5Block> blocks = {first_block(file, header, second, flags)};
  constexpr std::size_t kMostBlocks = 1000;  // a header that goes round in a circle has no end
  for (std::size_t i = 0; i < blocks.size() && i < kMostBlocks; ++i) {
    const Hdf5Block block = blocks[i];
    file.text(block.place, block.length);
    const std::uint64_t head = second ? (flags & 0x04 ? 6 : 4) : 8, end = block.place + block.length;
    for (std::uint64_t place = block.place; place + head <= end;) {
      const unsigned type = second ? file.at<std::uint8_t>(place) : file.at<std::uint16_t>(place);
      const std::uint64_t length = file.at<std::uint16_t>(place + (second ? 1 : 2));
      const unsigned message_flags = file.at<std::uint8_t>(place + (second ? 3 : 4));
      place += head;
      if (length > end - place)
        file.fail(place, fmt::format("a message of {} bytes", length), "one inside its block");
      constexpr unsigned kShared = 2;
      if (type == kHdf5Attribute && (message_flags & kShared) == 0)
        take_attribute(file, place, length, &values);
      if (type == kHdf5Continuation) {
        Hdf5Block next = {file.at<std::uint64_t>(place), file.at<std::uint64_t>(place + 8)};
        // In version 2 a signature stands before it, a checksum behind.
        if (second && next.length < 8)
          file.fail(place, "a part of a header without content", "8 bytes or more");
        if (second) next = {next.place + 4, next.length - 8};
        blocks.push_back(next);
      }
      place += length;
    }
  }
  return values;
}

std::string_view hdf5_heap_value(const FileBytes& file, std::string_view pointer,
                                 std::uint64_t element_bytes) {
  const FileBytes where = file.with(pointer);
  const std::uint64_t count = where.at<std::uint32_t>(0), heap = where.at<std::uint64_t>(4);
  const std::uint64_t index = where.at<std::uint32_t>(12);
  if (count == 0) return {};
  if (file.text(heap, 4) != "GCOL" || file.at<std::uint8_t>(heap + 4) != 1)
    file.fail(heap, "no global heap of version 1", "GCOL, then the values of variable length");
  const std::uint64_t size = file.at<std::uint64_t>(heap + 8);
  file.text(heap, size);
  for (std::uint64_t place = heap + 16; place + 16 <= heap + size;) {
    const std::uint64_t found = file.at<std::uint16_t>(place), length = file.at<std::uint64_t>(place + 8);
    if (found == 0 || length > heap + size - place - 16) break;  // free space, or damage
    if (found == index) {
      if (length / element_bytes != count || length % element_bytes != 0)
        file.fail(place, fmt::format("{} bytes", length),
                  fmt::format("{} elements of {} bytes", count, element_bytes));
      return file.text(place + 16, length);
    }
    place += 16 + (length + 7) / 8 * 8;
  }
  file.fail(heap, fmt::format("a heap without value {}", index), "the value that an attribute points to");
}

}  // namespace aberfit::internal
